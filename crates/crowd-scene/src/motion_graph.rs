//! Motion graphs: which clips somebody plays, for how long, and how one gives way to the next.
//!
//! ```text
//! # crowd motion graph v1
//! #      name    clip   for      least most
//! state  stands  idle   seconds  4     12
//! state  strolls walk   seconds  6     20
//! state  hurries run    seconds  3     8
//! state  waves   wave   turns    1     2
//! #      from    to      fade_s
//! way    stands  strolls 0.4
//! way    strolls stands  0.4     weight 2      # twice as often as the others
//! way    strolls hurries 0.3     in-step       # feet meet: both clips go by one count of steps
//! way    hurries strolls 0.3     in-step
//! way    stands  waves   0.3
//! way    waves   stands  0.3
//! ```
//!
//! A clip is named, or else by a part of its name, and looked up for each character. Every state must lead back to every other, so that
//! what people do can go round: see [`MotionGraph::schedule`].

use crate::text::{Line, lines_after, wrong, wrong_in_words};
use crate::{Error, Gait, Result};

const HEADING: &str = "# crowd motion graph v1";
/// States of a graph.
const MOST_STATES: usize = 64;
/// Seconds of a stay.
const LONGEST_STAY_S: f32 = 3600.0;
/// Turns of a stay.
const MOST_TURNS: usize = 1000;
/// Seconds of a fade.
const LONGEST_FADE_S: f32 = 10.0;

/// States and the ways between them; each leads to all others.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionGraph {
    pub(crate) states: Vec<MotionState>,
    pub(crate) ways: Vec<MotionWay>,
}

/// A clip that people play for a while.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionState {
    /// As ways name it.
    pub name: String,
    /// Name of the clip, or a part of it.
    pub clip: String,
    /// For how long.
    pub stay: Stay,
}

/// How long somebody stays, from the least to the most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stay {
    /// Seconds.
    Seconds(f32, f32),
    /// Whole turns of the clip; the fade to the next one ends with the last.
    Turns(u32, u32),
}

/// From one state to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionWay {
    /// Index of the state that is left.
    pub from: usize,
    /// Index of the state that begins.
    pub to: usize,
    /// Seconds in which the one gives way to the other.
    pub fade_s: f32,
    /// Both clips go by one count of turns, so that feet meet.
    pub is_in_step: bool,
    /// How often it is taken, beside the other ways of its state.
    pub weight: f32,
}

/// A clip for [`MotionGraph::usual`].
#[derive(Debug, Clone, PartialEq)]
pub struct UsualClip {
    /// Its name.
    pub name: String,
    /// What people do in it; `None`: something that is done once.
    pub gait: Option<Gait>,
}

impl MotionGraph {
    /// Reads the text file described above.
    ///
    /// # Errors
    /// [`Error::Format`] with the line: another heading, an unknown word, a number out of range, a state twice, a way to a state that is
    /// not there or twice, a fade longer than the shortest stay it leads to, no state, a state that does not lead to all others.
    /// [`Error::Limit`] past 64 states.
    pub fn parse(text: &str) -> Result<Self> {
        let mut graph = Self { states: Vec::new(), ways: Vec::new() };
        let mut lines = Vec::new();
        for line in lines_after(text, HEADING)? {
            match line.word(0) {
                "state" => {
                    if graph.states.len() == MOST_STATES {
                        return Err(Error::Limit { line: line.number, allowed: MOST_STATES });
                    }
                    let state = read_state(&line)?;
                    if graph.states.iter().any(|other| other.name == state.name) {
                        return Err(wrong(line.number, &state.name, "a name that no other state has"));
                    }
                    graph.states.push(state);
                    lines.push(line.number);
                }
                "way" => {
                    let way = graph.read_way(&line)?;
                    graph.ways.push(way);
                }
                other => return Err(wrong(line.number, other, "`state` or `way`")),
            }
        }
        if graph.states.is_empty() {
            return Err(wrong_in_words(text.lines().count().max(1), "no state", "at least one `state`"));
        }
        let together = graph.together_with(0, &vec![true; graph.states.len()]);
        if let Some(alone) = together.iter().position(|&is_in| !is_in) {
            let (name, first) = (&graph.states[alone].name, &graph.states[0].name);
            let expected = format!("ways from `{first}` to `{name}` and back, over others if need be");
            return Err(wrong(lines[alone], name, &expected));
        }
        Ok(graph)
    }

    /// A graph of some clips, when nobody gives one: standing leads to walking and back, walking to running and back in step, and from
    /// the calmest of them to everything else and back. `None` where there are no clips.
    pub fn usual(clips: &[UsualClip]) -> Option<Self> {
        let clips = &clips[..clips.len().min(MOST_STATES)];
        let of = |gait: Gait| (0..clips.len()).find(|&i| clips[i].gait == Some(gait));
        let [idle, walk, run] = [Gait::Idle, Gait::Walk, Gait::Run].map(of);
        let calmest = idle.or(walk).or(run).unwrap_or(0);
        let stay = |clip: &UsualClip| match clip.gait {
            Some(Gait::Idle) => Stay::Seconds(3.0, 10.0),
            Some(Gait::Walk) => Stay::Seconds(5.0, 15.0),
            Some(Gait::Run) => Stay::Seconds(3.0, 8.0),
            None => Stay::Turns(1, 2),
        };
        let state = |(i, clip): (usize, &UsualClip)| MotionState {
            name: format!("{i}"),
            clip: clip.name.clone(),
            stay: stay(clip),
        };
        let mut ways = Vec::new();
        let mut both = |a: usize, b: usize, fade_s: f32, is_in_step: bool| {
            for (from, to) in [(a, b), (b, a)] {
                ways.push(MotionWay { from, to, fade_s, is_in_step, weight: 1.0 });
            }
        };
        for i in 0..clips.len() {
            match clips[i].gait {
                _ if i == calmest => {}
                Some(Gait::Run) if run == Some(i) && walk.is_some_and(|walk| walk != i) => {
                    both(walk.unwrap_or(i), i, 0.3, true);
                }
                // Another walk or run follows the first of its kind in step.
                Some(gait) if gait != Gait::Idle && of(gait).is_some_and(|first| first != i) => {
                    both(of(gait).unwrap_or(i), i, 0.3, true);
                }
                Some(_) => both(calmest, i, 0.4, false),
                None => both(calmest, i, 0.3, false),
            }
        }
        (!clips.is_empty()).then(|| Self { states: clips.iter().enumerate().map(state).collect(), ways })
    }

    /// Its states, in their order.
    pub fn states(&self) -> &[MotionState] {
        &self.states
    }

    /// Its ways.
    pub fn ways(&self) -> &[MotionWay] {
        &self.ways
    }

    /// States from which one can go to `state` and come back, over states that `is_there`.
    pub(crate) fn together_with(&self, state: usize, is_there: &[bool]) -> Vec<bool> {
        let reach = |ends: fn(&MotionWay) -> (usize, usize)| {
            let mut reached = vec![false; self.states.len()];
            let mut open = vec![state];
            while let Some(at) = open.pop() {
                if std::mem::replace(&mut reached[at], true) {
                    continue;
                }
                let next = self.ways.iter().map(ends).filter(|&(from, to)| from == at && is_there[to]);
                open.extend(next.map(|(_, to)| to).filter(|&to| !reached[to]));
            }
            reached
        };
        let (there, back) = (reach(|way| (way.from, way.to)), reach(|way| (way.to, way.from)));
        there.into_iter().zip(back).map(|(there, back)| there && back).collect()
    }

    /// The longest fade into a state, seconds.
    pub(crate) fn longest_fade_into(&self, state: usize) -> f32 {
        self.ways.iter().filter(|way| way.to == state).map(|way| way.fade_s).fold(0.0, f32::max)
    }

    fn read_way(&self, line: &Line<'_>) -> Result<MotionWay> {
        line.must_have_between(4, 7, "way, from, to, fade_s, and perhaps in-step or weight and a number")?;
        let names: Vec<String> = self.states.iter().map(|state| state.name.clone()).collect();
        let state = |word: usize| {
            let found = line.word(word);
            let known = || format!("the name of a state above: {}", names.join(", "));
            names.iter().position(|name| name == found).ok_or_else(|| wrong(line.number, found, &known()))
        };
        let (from, to) = (state(1)?, state(2)?);
        if from == to {
            return Err(wrong(line.number, line.word(2), "another state than the one that is left"));
        }
        if self.ways.iter().any(|way| (way.from, way.to) == (from, to)) {
            return Err(wrong_in_words(line.number, "the same way again", "each way once"));
        }
        let fade_s = line.number_in(3, "seconds of the fade", 0.0, LONGEST_FADE_S)?;
        if let Stay::Seconds(least, _) = self.states[to].stay
            && fade_s > least
        {
            let expected = format!("at most the {least} s that `{}` lasts", names[to]);
            return Err(wrong(line.number, line.word(3), &expected));
        }
        let mut way = MotionWay { from, to, fade_s, is_in_step: false, weight: 1.0 };
        let mut word = 4;
        while word < line.word_count() {
            match line.word(word) {
                "in-step" => way.is_in_step = true,
                "weight" => {
                    word += 1;
                    way.weight = line.number_in(word, "weight", 0.001, 1000.0)?;
                }
                other => return Err(wrong(line.number, other, "`in-step`, or `weight` and a number")),
            }
            word += 1;
        }
        Ok(way)
    }
}

fn read_state(line: &Line<'_>) -> Result<MotionState> {
    line.must_have(6, "state, name, clip, seconds or turns, least, most")?;
    let stay = match line.word(3) {
        "seconds" => {
            let least = line.number_in(4, "seconds at least", 0.1, LONGEST_STAY_S)?;
            Stay::Seconds(least, line.number_in(5, "seconds at most", least, LONGEST_STAY_S)?)
        }
        "turns" => {
            let turns = |word: usize, name: &str| line.index_below(word, name, MOST_TURNS + 1);
            let (least, most) = (turns(4, "turns at least")?, turns(5, "turns at most")?);
            if least == 0 || most < least {
                return Err(wrong(line.number, &format!("{least} {most}"), "at least one turn, and no fewer at most"));
            }
            Stay::Turns(least, most)
        }
        other => return Err(wrong(line.number, other, "`seconds` or `turns`")),
    };
    Ok(MotionState { name: line.word(1).to_owned(), clip: line.word(2).to_owned(), stay })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GOOD: &str = "# crowd motion graph v1\nstate a idle seconds 1 2\nstate b walk turns 1 3 # comment\nway a b 0.5\nway b a 0.2 in-step weight 2\n";

    #[test]
    fn a_graph_is_read() {
        let graph = MotionGraph::parse(GOOD).unwrap();
        assert_eq!(graph.states()[1], MotionState { name: "b".into(), clip: "walk".into(), stay: Stay::Turns(1, 3) });
        let way = MotionWay { from: 1, to: 0, fade_s: 0.2, is_in_step: true, weight: 2.0 };
        assert_eq!(graph.ways()[1], way);
    }

    #[test]
    fn refusals_name_the_line_and_what_was_found() {
        let table = [
            ("", "line 1: found nothing, expected `# crowd motion graph v1`"),
            ("# crowd motion graph v1\n", "no state"),
            ("# crowd motion graph v1\nstay a", "line 2: found `stay`, expected `state` or `way`"),
            ("# crowd motion graph v1\nstate a idle seconds 1", "line 2: found 5 words"),
            ("# crowd motion graph v1\nstate a idle hours 1 2", "`seconds` or `turns`"),
            ("# crowd motion graph v1\nstate a idle seconds nan 2", "found `nan`"),
            ("# crowd motion graph v1\nstate a idle seconds 3 2", "found `2`"),
            ("# crowd motion graph v1\nstate a idle turns 0 2", "at least one turn"),
            ("# crowd motion graph v1\nstate a idle turns 1 99999999999", "turns at most"),
            ("# crowd motion graph v1\nstate a i seconds 1 2\nstate a j seconds 1 2", "line 3: found `a`"),
            ("# crowd motion graph v1\nstate a i seconds 1 2\nway a b 0.1", "the name of a state above: a"),
            ("# crowd motion graph v1\nstate a i seconds 1 2\nway a a 0.1", "another state"),
            (&format!("{GOOD}way a b 0.1"), "each way once"),
            (&format!("{GOOD}state c i seconds 1 2"), "line 6: found `c`, expected ways from `a` to `c` and back"),
            (&format!("{GOOD}state c i seconds 1 2\nway a c 0.1"), "line 6: found `c`"),
            (&format!("{GOOD}state c i seconds 1 2\nway a c 1.5"), "at most the 1 s that `c` lasts"),
            (&format!("{GOOD}state c i seconds 1 2\nway a c inf"), "seconds of the fade"),
            (&format!("{GOOD}state c i seconds 1 2\nway a c 0.1 weight -1"), "weight"),
            (&format!("{GOOD}state c i seconds 1 2\nway a c 0.1 loudly"), "`in-step`"),
        ];
        for (text, expected) in table {
            let error = MotionGraph::parse(text).expect_err(text).to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
        let many: String = (0..65).map(|i| format!("state s{i} x seconds 1 2\n")).collect();
        assert!(MotionGraph::parse(&format!("{HEADING}\n{many}")).is_err_and(|e| e.to_string().contains("64")));
    }

    #[test]
    fn without_a_file_walking_leads_to_running_and_everything_goes_round() {
        let clip = |name: &str, gait| UsualClip { name: name.to_owned(), gait };
        let clips = [
            clip("Wave", None),
            clip("Run", Some(Gait::Run)),
            clip("Walk", Some(Gait::Walk)),
            clip("Idle", Some(Gait::Idle)),
            clip("Walk_Sad", Some(Gait::Walk)),
        ];
        for some in [&clips[..], &clips[..1], &clips[1..3], &clips[..2], &clips[2..]] {
            let graph = MotionGraph::usual(some).unwrap();
            let all = vec![true; some.len()];
            assert_eq!(graph.together_with(0, &all), all, "{some:?}");
            for way in graph.ways() {
                let gaits = [way.from, way.to].map(|state| some[state].gait);
                let both_go = gaits.iter().all(|gait| matches!(gait, Some(Gait::Walk | Gait::Run)));
                assert_eq!(way.is_in_step, both_go);
            }
        }
        assert_eq!(MotionGraph::usual(&[]), None);
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "(# crowd motion graph v1\n)?(state|way|a|b|[0-9.]{1,4}|in-step|turns|[ \n]){0,60}") {
            let _ = MotionGraph::parse(&text);
        }
    }
}
