//! What a crowd on its places plays from second to second: a motion graph gone through for each character.

use crate::moving::gait_of;
use crate::plan::MotionPlanWord;
use crate::step_match::turns_ahead;
use crate::view::read_text;
use crate::{Error, Result};
use crowd_scene::{MotionGraph, Schedule, StateClip, UsualClip, deal_schedule};
use crowd_stages::gpu::MotionPlan;
use crowd_stages::{CrowdData, InstanceRecord, MotionRecord, MotionSchedule, MotionStretch, cpu};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Ways through its graph that a character's people share, each from a time of their own.
const SCHEDULES_EACH: u32 = 32;
/// Bytes of a motion graph: far more than its most ways need.
const GRAPH_BYTES: u64 = 1 << 20;

/// Schedules, and who goes by which.
#[derive(Debug, Clone, Default)]
pub struct Schedules {
    stretches: Vec<MotionStretch>,
    schedules: Vec<MotionSchedule>,
    motions: Vec<MotionRecord>,
}

/// A character that people of the crowd are.
pub struct Actor<'a> {
    /// Number in the pack.
    pub character: u32,
    /// Its name.
    pub name: &'a str,
    /// Names of all its clips.
    pub clip_names: Vec<&'a str>,
    /// Those that may play unless a graph names others.
    pub clips: &'a [u32],
}

impl Schedules {
    /// Goes through the graph asked for; `None` where none is. Also what there is to say of characters that lack clips of it.
    ///
    /// # Errors
    /// [`Error::Scene`] for a file that was refused or of which no character has a clip.
    pub fn open(
        word: &MotionPlanWord,
        data: &CrowdData,
        actors: &[Actor<'_>],
        instances: &[InstanceRecord],
        seed: u32,
        remarks: &mut Vec<String>,
    ) -> Result<Option<Self>> {
        let given = match word {
            MotionPlanWord::Off => return Ok(None),
            MotionPlanWord::Usual => None,
            MotionPlanWord::File(path) => {
                let refused = |e: crowd_scene::Error| Error::Scene { path: path.clone(), problem: e.to_string() };
                Some(MotionGraph::parse(&read_text(path, GRAPH_BYTES)?).map_err(refused)?)
            }
        };
        let mut all = Self::default();
        // By character of the pack: the first of its schedules.
        let mut firsts: BTreeMap<u32, u32> = BTreeMap::new();
        for actor in actors {
            let usual = || MotionGraph::usual(&usual_clips(actor));
            let Some(graph) = given.clone().or_else(usual) else { continue };
            let clips = state_clips(&graph, data, actor);
            if given.is_some() {
                remarks.extend(missing(&graph, &clips, actor));
            }
            if let Some(first) = all.add(&graph, data, actor.character, &clips, seed) {
                firsts.insert(actor.character, first);
            }
        }
        if let (MotionPlanWord::File(path), true) = (word, firsts.is_empty()) {
            let problem =
                "found a clip of it in no character, allowed names or parts of names of their clips".to_owned();
            return Err(Error::Scene { path: path.clone(), problem });
        }
        let deal = |(index, instance): (u32, &InstanceRecord)| {
            let nobody = MotionRecord { schedule: crowd_pack::NONE, ahead_s: 0.0 };
            firsts.get(&instance.character).map_or(nobody, |first| {
                let (number, share) = deal_schedule(index, seed, SCHEDULES_EACH);
                let schedule = first + number;
                MotionRecord { schedule, ahead_s: share * all.schedules[schedule as usize].loop_s }
            })
        };
        let motions: Vec<MotionRecord> = (0..).zip(instances).map(deal).collect();
        Ok(Some(Self { motions, ..all }))
    }

    /// For the GPU.
    pub fn plan(&self) -> MotionPlan<'_> {
        let Self { stretches, schedules, motions } = self;
        MotionPlan { stretches, schedules, motions }
    }

    /// Sets what everyone plays by now, on the CPU.
    pub fn play(&self, data: &CrowdData, time_s: f32, instances: &mut [InstanceRecord]) {
        cpu::play_motion(&data.clips, &self.stretches, &self.schedules, &self.motions, time_s, instances);
    }

    /// Adds the schedules of a character; the number of the first.
    fn add(
        &mut self,
        graph: &MotionGraph,
        data: &CrowdData,
        character: u32,
        clips: &[Option<StateClip>],
        seed: u32,
    ) -> Option<u32> {
        // Each pair once: it is thousands of vertices posed.
        let known: RefCell<BTreeMap<(u32, u32), f32>> = RefCell::default();
        let ahead = |clip: u32, other: u32| {
            *known.borrow_mut().entry((clip, other)).or_insert_with(|| turns_ahead(data, character, clip, other))
        };
        let first = self.schedules.len() as u32;
        for number in 0..SCHEDULES_EACH {
            let Schedule { stretches, loop_s } = graph.schedule(clips, &ahead, seed ^ character, number)?;
            let (begin, count) = (self.stretches.len() as u32, stretches.len() as u32);
            self.schedules.push(MotionSchedule { first: begin, count, loop_s, reserved: 0 });
            self.stretches.extend(stretches.iter().map(record));
        }
        Some(first)
    }
}

fn record(one: &crowd_scene::MotionStretch) -> MotionStretch {
    MotionStretch {
        start_s: one.start_s,
        fade_s: one.fade_s,
        clip: one.clip,
        turns: one.turns,
        first_rate_hz: one.first_rate_hz,
        rate_hz: one.rate_hz,
        left_clip: one.left_clip,
        left_turns: one.left_turns,
        left_rate_hz: one.left_rate_hz,
        left_last_rate_hz: one.left_last_rate_hz,
        ..Default::default()
    }
}

/// The clips that may play, with what they are by their names.
fn usual_clips(actor: &Actor<'_>) -> Vec<UsualClip> {
    let of = |&clip: &u32| {
        let name = actor.clip_names.get(clip as usize)?;
        Some(UsualClip { name: (*name).to_owned(), gait: gait_of(name) })
    };
    actor.clips.iter().filter_map(of).collect()
}

/// What the character has for each state: the clip of that name, whatever its case, or else the first whose name contains it.
fn state_clips(graph: &MotionGraph, data: &CrowdData, actor: &Actor<'_>) -> Vec<Option<StateClip>> {
    let record = &data.characters[actor.character as usize];
    let of = |word: &str| {
        let exact = actor.clip_names.iter().position(|name| *name == word);
        let alike = || actor.clip_names.iter().position(|name| name.eq_ignore_ascii_case(word));
        let word = word.to_lowercase();
        let part = || actor.clip_names.iter().position(|name| name.to_lowercase().contains(&word));
        let found = exact.or_else(alike).or_else(part).filter(|&clip| clip < record.clip_count as usize)?;
        let clip = record.clip_offset + found as u32;
        Some(StateClip { clip, duration_s: data.clips[clip as usize].duration_s })
    };
    graph.states().iter().map(|state| of(&state.clip)).collect()
}

/// A sentence about states that a character has no clip for.
fn missing(graph: &MotionGraph, clips: &[Option<StateClip>], actor: &Actor<'_>) -> Option<String> {
    let names: Vec<&str> = graph
        .states()
        .iter()
        .zip(clips)
        .filter(|(_, clip)| clip.is_none())
        .map(|(state, _)| state.clip.as_str())
        .collect();
    (!names.is_empty()).then(|| format!("{}: no clip called {} of the motion graph", actor.name, names.join(", ")))
}
