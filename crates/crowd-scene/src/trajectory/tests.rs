use super::*;
use crate::Gait;
use proptest::prelude::*;

const DATABASE: &[u8] = include_bytes!("../../../../fixtures/scenes/crossing.sqlite");
const JUELICH: &[u8] = include_bytes!("../../../../fixtures/scenes/crossing_juelich.txt");
const VADERE: &[u8] = include_bytes!("../../../../fixtures/scenes/crossing_vadere.traj");
const CSV: &[u8] = include_bytes!("../../../../fixtures/scenes/crossing.csv");

fn read(text: &str) -> Result<Trajectories> {
    Trajectories::read(text.as_bytes(), None)
}

fn at(scene: &Trajectories, time_s: f32) -> Vec<Walker> {
    let mut walkers = Vec::new();
    scene.people_at(time_s, &mut walkers);
    walkers
}

fn who(scene: &Trajectories, id: u32, time_s: f32) -> Option<Walker> {
    at(scene, time_s).into_iter().find(|walker| walker.id == id)
}

#[test]
fn one_scene_in_four_formats_is_one_scene() {
    let scenes = [DATABASE, JUELICH, VADERE, CSV].map(|bytes| Trajectories::read(bytes, None).expect("a fixture"));
    for scene in &scenes {
        assert_eq!(scene.person_count(), 12);
        assert!((13.0..=14.0).contains(&scene.end_s()), "{}", scene.end_s());
    }
    let [database, juelich, vadere, csv] = &scenes;
    assert!(database.area().is_some() && juelich.area().is_none());
    for time_s in [0.0, 2.5, 5.1, 8.0, 11.9] {
        let [a, b, c] = [database, juelich, csv].map(|scene| at(scene, time_s));
        assert_eq!(a.len(), b.len(), "at {time_s}");
        // The middle is the area's in one and the people's in the others; names hash otherwise than numbers.
        let shift = a[0].position - b[0].position;
        for (one, other) in a.iter().zip(&b) {
            assert_eq!((one.id, one.gait), (other.id, other.gait));
            assert!((one.position - other.position - shift).length() < 0.02);
            assert!((one.speed_m_s - other.speed_m_s).abs() < 0.1);
        }
        assert_eq!(c.len(), a.len());
        assert!(at(vadere, time_s).len().abs_diff(a.len()) <= 2);
    }
}

/// Somebody who stands, walks, runs, and stands again: the gait and since when, seen by looking often, are what the walker says.
#[test]
fn people_know_since_when_they_stand_walk_or_run() {
    let speed_at = |t: f64| match t {
        t if t < 2.0 => 0.0,
        t if t < 5.0 => 1.2,
        t if t < 8.0 => 4.0,
        // Too short for a gait.
        t if (9.0..9.2).contains(&t) => 0.0,
        t if t < 11.0 => 1.2,
        _ => 0.0,
    };
    let (mut x, mut text) = (0.0, "# framerate: 20\n".to_owned());
    for frame in 0..280 {
        text.push_str(&format!("1 {frame} {x:.4} 0\n"));
        x += speed_at(f64::from(frame) * 0.05) * 0.05;
    }
    let scene = read(&text).expect("it is sound");
    let mut gaits = Vec::new();
    let mut since_s = f32::NEG_INFINITY;
    for step in 0..1390 {
        let time_s = step as f32 * 0.01;
        let now = who(&scene, 1, time_s).expect("always there");
        if gaits.last() != Some(&now.gait) {
            if let Some(before) = gaits.last() {
                assert_eq!(now.gait_before, *before);
                since_s = time_s;
            }
            gaits.push(now.gait);
        }
        let seen_s = time_s - since_s;
        assert!(now.changed_s == seen_s || (now.changed_s - seen_s).abs() < 0.012, "{} and {seen_s}", now.changed_s);
    }
    assert_eq!(gaits, [Gait::Idle, Gait::Walk, Gait::Run, Gait::Walk, Gait::Idle]);
}

#[test]
fn people_come_and_leave_and_come_back() {
    let scene = Trajectories::read(DATABASE, None).expect("a fixture");
    let present = |time_s: f32| at(&scene, time_s).len();
    assert_eq!((present(0.0), present(-0.1), present(99.0)), (1, 0, 0));
    assert!(present(6.0) >= 9);
    // Number 7 comes after 2.7 s and is away from its 4th to its 7th second.
    assert!(who(&scene, 7, 2.0).is_none() && who(&scene, 7, 5.0).is_some());
    assert!(who(&scene, 7, 8.0).is_none() && who(&scene, 7, 10.0).is_some());
    assert_eq!(scene.stay_count(), 13);
}

#[test]
fn speed_gait_and_heading_follow_the_way() {
    let scene = Trajectories::read(DATABASE, None).expect("a fixture");
    let walks = who(&scene, 1, 4.0).expect("present");
    assert_eq!(walks.gait, Gait::Walk);
    assert!((walks.speed_m_s - 1.26).abs() < 0.08, "{}", walks.speed_m_s);
    assert!((walks.yaw_rad - std::f32::consts::FRAC_PI_2).abs() < 0.1, "+x of the file is +X: {}", walks.yaw_rad);
    let down = who(&scene, 2, 4.0).expect("present");
    assert!(down.yaw_rad.abs() < 0.1, "-y of the file is +Z: {}", down.yaw_rad);
    assert_eq!(who(&scene, 3, 3.0).expect("present").gait, Gait::Run);
    // Number 5 stands from its 3rd to its 6th second and keeps facing where it went.
    let stands = who(&scene, 5, 1.8 + 4.5).expect("present");
    assert_eq!((stands.gait, stands.speed_m_s < 0.05), (Gait::Idle, true));
    assert!((stands.yaw_rad - std::f32::consts::FRAC_PI_2).abs() < 0.1);
    let (before, after) = (who(&scene, 1, 3.0).expect("there"), who(&scene, 1, 4.0).expect("there"));
    let ahead = after.position.x - before.position.x;
    assert!((after.walked_m - before.walked_m - ahead).abs() < 0.1);
    assert!((ahead - 1.26).abs() < 0.05, "straight between rows");
}

#[test]
fn gaits_last() {
    let scene = Trajectories::read(DATABASE, None).expect("a fixture");
    for id in 1..=12 {
        let mut changes = 0;
        let gaits: Vec<Gait> = (0..280).filter_map(|i| who(&scene, id, i as f32 * 0.05)).map(|w| w.gait).collect();
        changes += gaits.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(changes <= 2, "{id}: {changes}");
    }
}

#[test]
fn map_coordinates_keep_their_millimetres() {
    let text = "id,time,x,y\n1,0,5800000.000,680000.125\n1,1,5800001.001,680000.125\n2,0,5800004,680002\n";
    let scene = read(text).expect("good");
    assert_eq!(scene.origin(), [5_800_002.0, 680_001.062_5]);
    let (a, b) = (who(&scene, 1, 0.0).expect("there"), who(&scene, 1, 1.0).expect("there"));
    assert!((b.position.x - a.position.x - 1.001).abs() < 1e-5);
}

#[test]
fn rows_may_stand_in_any_order_and_unknown_columns_are_named() {
    let scene = Trajectories::read(CSV, None).expect("a fixture");
    assert_eq!(scene.remarks(), ["columns passed over: mood"]);
    let forwards = read("id,t,x,y\n1,0,0,0\n1,1,1,0\n2,0,5,5\n2,1,5,6\n").expect("good");
    let backwards = read("y\tx\tid\tt\n6\t5\t2\t1\n5\t5\t2\t0\n0\t1\t1\t1\n0\t0\t1\t0\n").expect("good");
    assert_eq!(at(&forwards, 0.3), at(&backwards, 0.3));
}

#[test]
fn steps_of_vadere_without_times_take_its_usual_step() {
    let scene = read("timeStep pedestrianId x-PID1 y-PID1\n1 1 0 0\n2 1 0.5 0\n").expect("good");
    assert!((scene.end_s() - 0.4).abs() < 1e-6);
    assert!(scene.remarks()[0].contains("0.4 s"), "{:?}", scene.remarks());
    let named = Trajectories::read(b"frame,id,x,y\n0,1,0,0\n25,1,1,0\n", Some(25.0)).expect("good");
    assert!((named.end_s() - 1.0).abs() < 1e-6);
}

#[test]
fn refusals_name_the_line_and_what_was_found() {
    for (text, expected) in [
        ("", "expected a heading that names a column id"),
        ("id,time,x,y\n", "the file: found nobody, expected at least one row with a person"),
        ("id,time,x\n1,2,3\n", "line 1: found `id,time,x`, expected a heading that names a column y"),
        ("id,x,y\n1,2,3\n", "expected a heading that names a column time (seconds) or frame"),
        ("id,frame,x,y\n1,2,3,4\n", "a column of frames and no frame rate"),
        ("id,time,x,y\n1,2,NaN,4\n", "line 2: found `NaN`, expected x, a finite number"),
        ("id,time,x,y\n1,2,inf,4\n", "line 2: found `inf`"),
        ("id,time,x,y\n1,2,1e12,4\n", "line 2: found `1000000000000`, expected x in metres"),
        ("id,time,x,y\n1,2,3\n", "line 2: found `1,2,3`, expected a value in column y"),
        ("id,time,x,y\n,2,3,4\n", "line 2: found `,2,3,4`, expected a value in column id"),
        (
            "id,time,x,y\n1,0,0,0\n1,0,9,9\n",
            "line 3: found `person 1 at two places at 0 s`, expected one place, as in line 2",
        ),
        ("id,time,x,y\n1,0,0,0\n1,2e6,0,0\n", "found 2000000 s from first to last row"),
        ("id,time,x,y\n1,0,0,0\n2,0,9e8,0\n", "m from one end to the other"),
        ("1 0 1 2 0\n", "heading: found no frame rate, expected a line such as `# framerate: 16 fps`"),
        ("# framerate: 0 fps\n1 0 1 2 0\n", "line 1: found `0`, expected frames a second"),
        ("# framerate: 5 fps\n1 0 1\n", "line 2: found 3 words, expected at least 4"),
        ("# framerate: 5 fps\n1 0 1 x 0\n", "line 2: found `x`, expected y, a finite number"),
        (
            "pedestrianId simTime endTime-PID1 startX-PID1 startY-PID1 endX-PID1 endY-PID1\n1 2 1 0 0 0 0\n",
            "line 2: found `1`, expected an end of the step",
        ),
    ] {
        let message = read(text).expect_err(text).to_string();
        assert!(message.contains(expected), "{message:?} should contain {expected:?}");
    }
    let message = Trajectories::read(b"id,t,x,y\n\xff\n", None).expect_err("no text").to_string();
    assert!(message.starts_with("line 2: found bytes that are no text"), "{message}");
}

#[test]
fn one_row_is_a_person_who_stands() {
    let scene = read("id,time,x,y\n9,5,1,2\n").expect("good");
    let walker = who(&scene, 9, 0.0).expect("there");
    assert_eq!((walker.gait, walker.speed_m_s, walker.position), (Gait::Idle, 0.0, Vec3::ZERO));
    assert_eq!(scene.end_s(), 0.0);
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused(text in "\\PC*", lines in "([0-9a-z.,;\t eE+-]{0,40}\n){0,12}") {
        for heading in ["", "id,time,x,y\n", "# framerate: 5 fps\n", "pedestrianId simTime endTime-PID1 startX-PID1 startY-PID1 endX-PID1 endY-PID1\n"] {
            for body in [&text, &lines] {
                let _ = Trajectories::read(format!("{heading}{body}").as_bytes(), Some(10.0));
            }
        }
    }

    /// Whatever the rows, walkers are somewhere finite, turn no faster than allowed, and nobody walks backwards in time.
    #[test]
    fn walkers_are_finite_and_steady(
        rows in proptest::collection::vec((0_u8..4, 0_u16..200, -50.0_f64..50.0, -50.0_f64..50.0), 1..80),
    ) {
        let mut seen = std::collections::BTreeSet::new();
        let mut text = String::from("id,time,x,y\n");
        for (id, tenth, x, y) in rows {
            if seen.insert((id, tenth)) {
                text += &format!("{id},{},{x},{y}\n", f64::from(tenth) * 0.1);
            }
        }
        let scene = read(&text).expect("good rows");
        for i in 0..60 {
            let time_s = scene.end_s() * i as f32 / 59.0;
            for walker in at(&scene, time_s) {
                prop_assert!(walker.position.is_finite() && walker.yaw_rad.is_finite() && walker.speed_m_s.is_finite());
                prop_assert!(walker.position.abs().max_element() <= 51.0 && walker.walked_m >= 0.0);
                if let Some(next) = who(&scene, walker.id, time_s + 0.01) {
                    prop_assert!(next.walked_m >= walker.walked_m || scene.stay_count() > scene.person_count());
                }
            }
        }
        for walker in scene.everyone() {
            prop_assert!(walker.position.is_finite());
        }
    }
}
