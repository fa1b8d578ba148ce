//! Scenes: one small crossing of two flows in every trajectory format the player reads, and its other text files.

use std::fmt::Write as _;

use crate::Fixture;
use crate::sqlite_file::{Table, Value, write_database};

const RATE_HZ: f64 = 5.0;
const END_S: f64 = 14.0;
const PEOPLE: i64 = 12;

/// For packs with `mara` and `oskar`, who have clips `idle` and `walk`.
const LAYOUT: &str = "\
# crowd layout v1
# x y z  yaw_deg  scale  character  clip  phase_s
-0.6 0 0   20  1.0  mara  idle  0
 0.6 0 0  -20  1.0  oskar idle  0.5     # the two talk
#     layout  count  x z    yaw_deg  spacing_m  seed
place disc    40     0 -6   0        0.9        3
place street  24     9 0    0        1.1        4
";
const WAYPOINTS: &str = "\
# crowd waypoints v1
route 3              # a round way, 3 m wide
-12 8
 12 8
 12 -8   2.5         # a red light
-12 -8
route 1              # to and fro
0 -6
0  6     1
";
const MOTION: &str = "\
# crowd motion graph v1
# People stand about, stroll, hurry in step with their strolling, and stand again.
#      name     clip   for      least most
state  stands   idle   seconds  2     6
state  strolls  walk   seconds  4     9
state  hurries  run    seconds  2     5
#      from     to       fade_s
way    stands   strolls  0.4
way    strolls  stands   0.4     weight 2
way    strolls  hurries  0.3     in-step
way    hurries  strolls  0.3     in-step
";
const CAMERA: &str = "\
# crowd camera path v1
# time_s  eye x y z  target x y z  fov_deg
0  0 6 24  0 1 0  45
#     seconds  eye x y z  target x y z  fov_deg
line  4        0 2 14     0 1 0         45
#     seconds  target x y z  distance  elevation_deg  from_deg to_deg  fov_deg
orbit 8        0 1 0         14.035669 4.085616       0 180            45
#           seconds  low x z  high x z  eye height  fov_deg
walkthrough 20       -12 -8   12 8      1.7         50
";

/// A street of 24 m by 120 m with walls along its middle and across it.
const STREET: &str = "\
POLYGON ((-12 -60, 12 -60, 12 60, -12 60, -12 -60),
 (-0.3 -50, -0.3 -6, 0.3 -6, 0.3 -50, -0.3 -50),
 (-0.3 6, -0.3 50, 0.3 50, 0.3 6, -0.3 6),
 (-12 20, -12 20.4, -2 20.4, -2 20, -12 20),
 (2 -12.4, 2 -12, 12 -12, 12 -12.4, 2 -12.4))
";

/// The files of `scenes/`.
pub fn scenes() -> Vec<Fixture> {
    let file = |name: &str, bytes: Vec<u8>| Fixture { path: format!("scenes/{name}"), bytes };
    vec![
        file("crossing.sqlite", crossing_database()),
        file("crossing_juelich.txt", crossing_juelich().into_bytes()),
        file("crossing_vadere.traj", crossing_steps().into_bytes()),
        file("crossing.csv", crossing_csv().into_bytes()),
        file("layout.txt", LAYOUT.into()),
        file("waypoints.txt", WAYPOINTS.into()),
        file("camera.txt", CAMERA.into()),
        file("motion.txt", MOTION.into()),
        file("street.wkt", STREET.into()),
    ]
}

/// Where person `id` is at `time_s`, metres; `None` before it comes and after it left.
///
/// Odd ones walk along x, even ones along y, through an area of 16 m x 16 m. Number 3 runs; number 5 stands still for
/// three seconds; number 7 is out of sight for three seconds.
fn place_of(id: i64, time_s: f64) -> Option<[f64; 2]> {
    let start = 0.45 * (id - 1) as f64;
    let since = time_s - start;
    let (speed, stands) = match id {
        3 => (3.2, 0.0),
        5 => (1.3, 3.0),
        _ => (1.2 + 0.06 * (id % 4) as f64, 0.0),
    };
    let walking = if stands > 0.0 { since.min(3.0) + (since - 3.0 - stands).max(0.0) } else { since };
    let ahead = 0.5 + speed * walking;
    let hidden = id == 7 && (4.0..7.0).contains(&since);
    if since < 0.0 || ahead > 15.5 || hidden {
        return None;
    }
    // A stride sways by 2 cm.
    let lane = 6.6 + 0.45 * ((id - 1) / 2 % 6) as f64;
    let aside = lane + 0.02 * libm::sin(walking * 2.0 * std::f64::consts::PI);
    Some(if id % 2 == 1 { [ahead, aside] } else { [aside, 16.0 - ahead] })
}

fn frames() -> impl Iterator<Item = (i64, f64)> {
    (0..=(END_S * RATE_HZ) as i64).map(|frame| (frame, frame as f64 / RATE_HZ))
}

/// A cross of two corridors with a round pillar; long enough that its text leaves its database page.
fn area() -> String {
    let cross = "0 10, 0 6, 6 6, 6 0, 10 0, 10 6, 16 6, 16 10, 10 10, 10 16, 6 16, 6 10, 0 10";
    let pillar: Vec<String> = (0..=48)
        .map(|i| {
            let (sin, cos) = libm::sincos(f64::from(i % 48) * std::f64::consts::TAU / 48.0);
            format!("{:.6} {:.6}", 9.5 + 0.2 * cos, 9.5 + 0.2 * sin)
        })
        .collect();
    format!("POLYGON (({cross}), ({}))", pillar.join(", "))
}

fn crossing_database() -> Vec<u8> {
    let hash = 1_234_567_890_123;
    let text = |s: &str| Value::Text(s.to_owned());
    let mut rows = Vec::new();
    for (frame, time_s) in frames() {
        for id in 1..=PEOPLE {
            if let Some([x, y]) = place_of(id, time_s) {
                let nowhere = [Value::Real(0.0), Value::Real(0.0)];
                rows.push(
                    [vec![Value::Integer(frame), Value::Integer(id), Value::Real(x), Value::Real(y)], nowhere.to_vec()]
                        .concat(),
                );
            }
        }
    }
    write_database(&[
        Table {
            name: "trajectory_data",
            columns: "frame INTEGER NOT NULL, id INTEGER NOT NULL, pos_x REAL NOT NULL, pos_y REAL NOT NULL, \
                      ori_x REAL NOT NULL, ori_y REAL NOT NULL",
            rows,
        },
        Table {
            name: "metadata",
            columns: "key TEXT NOT NULL, value TEXT NOT NULL",
            rows: vec![vec![text("version"), text("2")], vec![text("fps"), text("5.0")]],
        },
        Table {
            name: "geometry",
            columns: "hash INTEGER NOT NULL, wkt TEXT NOT NULL",
            rows: vec![vec![Value::Integer(hash), Value::Text(area())]],
        },
        Table {
            name: "frame_data",
            columns: "frame INTEGER NOT NULL, geometry_hash INTEGER NOT NULL",
            rows: frames().map(|(frame, _)| vec![Value::Integer(frame), Value::Integer(hash)]).collect(),
        },
    ])
}

fn crossing_juelich() -> String {
    let mut text = format!(
        "# description: two flows of {PEOPLE} people cross\n# framerate: {RATE_HZ:.2} fps\n# geometry: none\n# ID frame x/cm y/cm z/cm\n"
    );
    for id in 1..=PEOPLE {
        for (frame, time_s) in frames() {
            if let Some([x, y]) = place_of(id, time_s) {
                let _ = writeln!(text, "{id}\t{frame}\t{:.2}\t{:.2}\t170.00", x * 100.0, y * 100.0);
            }
        }
    }
    text
}

/// Steps as Vadere's event-driven models write them: from where and when to where and when.
fn crossing_steps() -> String {
    const STEP_S: f64 = 0.5;
    let mut text =
        String::from("pedestrianId simTime endTime-PID1 startX-PID1 startY-PID1 endX-PID1 endY-PID1 targetId-PID2\n");
    for step in 0..(END_S / STEP_S) as i64 {
        for id in 1..=PEOPLE {
            let (start, end) = (step as f64 * STEP_S, (step + 1) as f64 * STEP_S);
            if let (Some([x, y]), Some([to_x, to_y])) = (place_of(id, start), place_of(id, end)) {
                let target = 1 + id % 2;
                let _ = writeln!(text, "{id} {start:?} {end:?} {x:?} {y:?} {to_x:?} {to_y:?} {target}");
            }
        }
    }
    text
}

/// Names for ids, times for frames, an unknown column, and the last row first.
fn crossing_csv() -> String {
    let mut rows = Vec::new();
    for (_, time_s) in frames() {
        for id in 1..=PEOPLE {
            if let Some([x, y]) = place_of(id, time_s) {
                rows.push(format!("{time_s:.1};walker-{id};{x:.3};{y:.3};calm"));
            }
        }
    }
    rows.reverse();
    format!("time_s;agent;pos_x;pos_y;mood\n{}\n", rows.join("\n"))
}
