//! Crowds that move: a feed says who is where at a time, and each of them becomes an instance with a clip.

use crate::crowd::{ROUND, UNUSUAL_CLIPS};
use crate::plan::FeedPlan;
use crate::scenery::Scenery;
use crate::step_match::turns_ahead;
use crate::{Error, Result};
use crowd_pack::ManifestClip;
use crowd_scene::{
    Cast, Flock, FlockRules, Gait, GaitClip, Instance, Mover, RootPath, Trajectories, Walker, Waypoints,
};
use crowd_stages::CrowdData;
use glam::Vec3;
use std::path::Path;

/// Bytes of a file of trajectories.
const TRAJECTORY_BYTES: u64 = 1 << 30;
/// Bytes of a file of waypoints.
const WAYPOINT_BYTES: u64 = 16 << 20;
/// Metres between people on a walk whose way nobody drew.
const WALK_SPACING_M: f32 = 1.2;

/// Who is where at a time.
#[derive(Debug, Clone)]
pub enum Feed {
    /// From a simulator's file; begins anew after its end.
    Trajectories(Box<Trajectories>),
    /// Simulated here.
    Flock(Box<Flock>),
    /// Along waypoints: the way, how many people, and the seed of their paces.
    Walk(Waypoints, u32, u32),
}

impl Feed {
    /// Opens what the plan asks for. Also what the reader has to say. `count`: people on a walk; `seed`: of directions and
    /// paces; `radius_m`: of somebody's body by number, metres.
    ///
    /// # Errors
    /// [`Error::Scene`] for a file that was refused.
    pub fn open(
        plan: &FeedPlan,
        count: u32,
        seed: u32,
        radius_m: impl Fn(u32) -> f32,
        remarks: &mut Vec<String>,
    ) -> Result<Self> {
        match plan {
            FeedPlan::Trajectories { path, rate_hz } => {
                refuse_unwritten(path)?;
                let refused = |problem: String| Error::Scene { path: path.clone(), problem };
                let bytes = crate::view::read_bytes(path, TRAJECTORY_BYTES)?;
                let ways = Trajectories::read(&bytes, *rate_hz).map_err(|e| refused(words(&e)))?;
                remarks.push(format!("{}: {} people, {:.1} s", path.display(), ways.person_count(), ways.end_s()));
                remarks.extend(ways.remarks().iter().map(|remark| format!("{}: {remark}", path.display())));
                Ok(Self::Trajectories(Box::new(ways)))
            }
            FeedPlan::Flock { count } => {
                Ok(Self::Flock(Box::new(Flock::of_bodies(*count, seed, FlockRules::default(), radius_m))))
            }
            FeedPlan::Walk { path: None } => Ok(Self::Walk(Waypoints::around(count, WALK_SPACING_M), count, seed)),
            FeedPlan::Walk { path: Some(path) } => {
                let text = crate::view::read_text(path, WAYPOINT_BYTES)?;
                let refused = |e: crowd_scene::Error| Error::Scene { path: path.clone(), problem: e.to_string() };
                Ok(Self::Walk(Waypoints::parse(&text).map_err(refused)?, count, seed))
            }
        }
    }

    /// Everyone there ever is, at least once each.
    pub fn everyone(&self) -> Vec<Walker> {
        match self {
            Self::Trajectories(ways) => ways.everyone(),
            Self::Flock(flock) => {
                let mut walkers = Vec::new();
                flock.people(&mut walkers);
                walkers
            }
            Self::Walk(ways, count, seed) => {
                let mut walkers = Vec::new();
                ways.people_at(*count, *seed, 0.0, &mut walkers);
                walkers
            }
        }
    }

    /// Corners of the ground that people ever stand on.
    pub fn extent(&self) -> (Vec3, Vec3) {
        match self {
            Self::Trajectories(ways) => ways.extent(),
            Self::Flock(flock) => {
                // The place is round: its box would have empty corners.
                let corner = ROUND * Vec3::new(flock.radius_m(), 0.0, flock.radius_m());
                (-corner, corner)
            }
            Self::Walk(ways, ..) => ways.extent(),
        }
    }

    fn people_at(&mut self, time_s: f32, walkers: &mut Vec<Walker>) {
        match self {
            Self::Trajectories(ways) => {
                let end_s = ways.end_s();
                ways.people_at(if end_s > 0.0 { time_s.rem_euclid(end_s) } else { 0.0 }, walkers);
            }
            Self::Flock(flock) => {
                flock.advance_to(time_s);
                flock.people(walkers);
            }
            Self::Walk(ways, count, seed) => ways.people_at(*count, *seed, time_s, walkers),
        }
    }
}

/// A refusal with the option that helps, where there is one.
fn words(error: &crowd_scene::Error) -> String {
    error.to_string().replace("or name the rate", "or name the rate with --trajectory-rate")
}

/// A database whose newest rows lie in a journal beside it would be shown in part.
fn refuse_unwritten(path: &Path) -> Result<()> {
    let mut journal = path.as_os_str().to_owned();
    journal.push("-wal");
    let journal = Path::new(&journal);
    if std::fs::metadata(journal).is_ok_and(|file| file.len() > 0) {
        let problem = format!(
            "found rows not yet in the database, in {}; let the simulator close it, or run `sqlite3 FILE 'PRAGMA wal_checkpoint(TRUNCATE)'`",
            journal.display()
        );
        return Err(Error::Scene { path: path.to_owned(), problem });
    }
    Ok(())
}

/// A feed and its cast.
#[derive(Debug, Clone)]
pub struct Moving {
    feed: Feed,
    cast: Cast,
    walkers: Vec<Walker>,
}

impl Moving {
    /// `cast`: with a mover for each character that the scene uses.
    pub fn new(feed: Feed, cast: Cast) -> Self {
        Self { feed, cast, walkers: Vec::new() }
    }

    /// Everyone there ever is, at least once each; characters as indices of movers.
    pub fn everyone(&self) -> Vec<Instance> {
        self.feed.everyone().iter().map(|walker| self.cast.instance(walker, 0.0)).collect()
    }

    /// The flock and its cast, if that is what moves.
    pub fn flock(&self) -> Option<(&Flock, &Cast)> {
        match &self.feed {
            Feed::Flock(flock) => Some((flock, &self.cast)),
            Feed::Trajectories(_) | Feed::Walk(..) => None,
        }
    }

    /// Corners of the ground that people ever stand on.
    pub fn extent(&self) -> (Vec3, Vec3) {
        self.feed.extent()
    }

    /// Ground and walls, where the feed knows any.
    ///
    /// # Errors
    /// [`Error::Scene`] for an area of too many pieces.
    pub fn scenery(&self) -> Result<Scenery> {
        let area = match &self.feed {
            Feed::Trajectories(ways) => ways.area(),
            Feed::Flock(_) | Feed::Walk(..) => None,
        };
        let refused = |e: crowd_scene::Error| Error::Scene { path: "--trajectories".into(), problem: e.to_string() };
        area.map_or(Ok(Scenery::default()), |area| Scenery::of_area(area).map_err(refused))
    }

    /// Those present at a time.
    pub fn people_at(&mut self, time_s: f32) -> impl Iterator<Item = Instance> + '_ {
        let Self { feed, cast, walkers } = self;
        feed.people_at(time_s, walkers);
        walkers.iter().map(move |walker| cast.instance(walker, time_s))
    }
}

/// The clips of a character for standing, walking and running. `names`: of all its clips, in their order; `allowed`: those
/// that may play; `factor`: the size the character is shown at.
pub fn mover(data: &CrowdData, character: u32, names: &[&str], allowed: &[u32], factor: f32) -> Mover {
    let clips = gait_clips(names, allowed).map(|clip| gait_clip(data, character, clip));
    let first_clip = data.characters[character as usize].clip_offset;
    let [_, walk, run] = clips.map(|clip| first_clip + clip.clip);
    Mover { clips, scale: factor, run_ahead_turns: turns_ahead(data, character, walk, run) }
}

/// The same with the root paths of its clips, so that planted feet stay. `clips`: all of the character's, in their order.
pub fn with_root_paths(mut mover: Mover, clips: &[ManifestClip]) -> Mover {
    for clip in &mut mover.clips {
        let path = clips.get(clip.clip as usize).map(|named| named.root_path_m.as_slice());
        clip.root_path = RootPath::of(path.unwrap_or_default());
    }
    mover
}

const IDLE: &[&str] = &["idle", "stand", "breath", "survey", "wait", "graze", "look"];
const WALK: &[&str] = &["walk"];
const RUN: &[&str] = &["run", "jog", "sprint", "gallop", "trot"];

/// What people do in a clip of that name; `None`: anything else, also walking backwards.
pub fn gait_of(name: &str) -> Option<Gait> {
    let name = name.to_lowercase();
    if UNUSUAL_CLIPS.iter().any(|word| name.contains(word)) {
        return None;
    }
    let gaits = [(Gait::Run, RUN), (Gait::Walk, WALK), (Gait::Idle, IDLE)];
    gaits.into_iter().find(|(_, words)| words.iter().any(|word| name.contains(word))).map(|(gait, _)| gait)
}

/// Of the clips allowed those for standing, walking, running; where one is missing, the nearest other.
fn gait_clips(names: &[&str], allowed: &[u32]) -> [u32; 3] {
    let lower = |clip: u32| names.get(clip as usize).map(|name| name.to_lowercase()).unwrap_or_default();
    let pick = |words: &[&str]| {
        let said = |clip: u32| words.iter().position(|word| lower(clip).contains(word));
        // The first word, then nothing unusual, then the plainest name.
        let rank = |clip: u32| {
            let name = lower(clip);
            (said(clip), UNUSUAL_CLIPS.iter().any(|word| name.contains(word)), name.len(), clip)
        };
        allowed.iter().copied().filter(|&clip| said(clip).is_some()).min_by_key(|&clip| rank(clip))
    };
    let (idle, walk, run) = (pick(IDLE), pick(WALK), pick(RUN));
    let any = allowed.first().copied().unwrap_or(0);
    [idle.or(walk).or(run), walk.or(run).or(idle), run.or(walk).or(idle)].map(|clip| clip.unwrap_or(any))
}

fn gait_clip(data: &CrowdData, character: u32, clip: u32) -> GaitClip {
    let record = &data.characters[character as usize];
    let clip = clip.min(record.clip_count.max(1) - 1);
    let stored = &data.clips[(record.clip_offset + clip) as usize];
    let [x, _, z] = stored.root_displacement_m;
    let moved = Vec3::new(x, 0.0, z);
    // A root that ends where it began only sways.
    let leaves = moved.length() > 0.05 * record.height_m && stored.duration_s > 0.0;
    GaitClip {
        clip,
        duration_s: stored.duration_s,
        ground_speed_m_s: stored.ground_speed_m_s,
        displacement_m: if leaves { moved } else { Vec3::ZERO },
        root_path: RootPath::default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaits_are_found_by_name_the_plainest_first() {
        let names = ["Attack", "Idle_Sword", "Idle", "Run_Back", "Walk_Formal", "Walk", "Running"];
        let all: Vec<u32> = (0..names.len() as u32).collect();
        assert_eq!(gait_clips(&names, &all), [2, 5, 6]);
        assert_eq!(gait_clips(&names, &[0, 1]), [1, 1, 1], "what is missing is replaced");
        assert_eq!(gait_clips(&["walk", "run", "graze"], &[0, 1, 2]), [2, 0, 1]);
        assert_eq!(gait_clips(&["a", "b"], &[1]), [1, 1, 1]);
        assert_eq!(gait_clips(&[], &[0]), [0, 0, 0]);
        let gaits = ["Idle_Look", "Walking_A", "Running_Strafe_Left", "Cheer", "Gallop"].map(gait_of);
        assert_eq!(gaits, [Some(Gait::Idle), Some(Gait::Walk), None, None, Some(Gait::Run)]);
    }
}
