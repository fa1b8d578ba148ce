//! From a pack to the instances of a crowd: who, where, with which clip.

use crate::bodies::{kept, kind, raised, usual_spacing, who_walks};
use crate::moving::{Feed, Moving, mover, with_root_paths};
use crate::plan::{ClipPlan, CrowdPlan, FeedPlan, HeightPlan, ImpostorsPlan, LayoutPlan, Simulator};
use crate::scenery::Scenery;
use crate::schedules::{Actor, Schedules};
use crate::view::read_text;
use crate::{Error, Result, stats};
use crowd_pack::{ManifestCharacter, Pack};
use crowd_scene::{Camera, Cast, Instance, Kind, Layout, WalkableArea};
use crowd_stages::{CrowdData, InstanceRecord, cpu};
use glam::Vec3;
use std::path::Path;

/// Everything the renderers and the report need to know of the crowd.
#[derive(Debug, Clone)]
pub struct Crowd {
    /// The pack, made ready for the stages.
    pub data: CrowdData,
    /// Who stands where.
    pub instances: Vec<InstanceRecord>,
    /// Numbers and names for the report.
    pub summary: stats::Crowd,
    /// Around all instances.
    pub bounds: Bounds,
    /// A camera that makes a picture of this crowd.
    pub framed: Camera,
    /// Choices made for the user, as sentences.
    pub remarks: Vec<String>,
    /// A crowd that moves: `instances` are everyone it ever has until [`Crowd::advance`] says who is there.
    pub moving: Option<Moving>,
    /// A crowd on its places that changes clips: see [`Crowd::play`].
    pub schedules: Option<Schedules>,
    /// What stands still around the crowd.
    pub scenery: Scenery,
    /// Who simulates a flock.
    pub simulator: Simulator,
    /// By the moving crowd's characters: the pack's character and the factor it is shown with.
    pub(crate) shown: Vec<(u32, f32)>,
}

impl Crowd {
    /// Sets `instances` to those present at a time; false for a crowd that stays where it is.
    pub fn advance(&mut self, time_s: f32) -> bool {
        let Some(moving) = &mut self.moving else { return false };
        self.instances.clear();
        self.instances.extend(moving.people_at(time_s).map(|one| record(&self.data, &self.shown, &one)));
        true
    }

    /// Triangles of those present at full detail.
    pub fn present_triangles(&self) -> u64 {
        let of = |one: &InstanceRecord| u64::from(self.data.characters[one.character as usize].triangle_count);
        self.instances.iter().map(of).sum()
    }

    /// Sets what everyone of a crowd on its places plays by now, for whoever draws or poses it on the CPU; the GPU looks it up
    /// itself.
    pub fn play(&mut self, time_s: f32) {
        if let Some(schedules) = &self.schedules {
            schedules.play(&self.data, time_s, &mut self.instances);
        }
    }
}

/// An instance of the scene as the stages have it.
fn record(data: &CrowdData, shown: &[(u32, f32)], one: &Instance) -> InstanceRecord {
    let (character, factor) = shown[one.character as usize];
    let first_clip = data.characters[character as usize].clip_offset;
    InstanceRecord {
        position: one.position.to_array(),
        yaw_rad: one.yaw_rad,
        scale: one.scale * factor,
        character,
        clip: first_clip + one.clip,
        phase_s: one.phase_s,
        leaving_clip: first_clip + one.leaving.clip,
        leaving_phase_s: one.leaving.phase_s,
        leaving_share: one.leaving.share,
        held_s: 0.0,
    }
}

/// Box around all instances, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Least corner.
    pub min: Vec3,
    /// Greatest corner.
    pub max: Vec3,
    /// Height of the tallest instance.
    pub height_m: f32,
}

impl Bounds {
    /// The crowd's middle, half a person above the ground.
    pub fn middle(&self) -> Vec3 {
        let centre = 0.5 * (self.min + self.max);
        Vec3::new(centre.x, self.min.y + 0.5 * self.height_m, centre.z)
    }
}

/// Corners at this share of a round place's box still have all of it in the picture.
pub(crate) const ROUND: f32 = 0.8;

/// Bytes of a layout file: some forty thousand people a megabyte.
const LAYOUT_BYTES: u64 = 1 << 30;

/// Bytes of a walkable area: far more than its most points need.
const WALKABLE_BYTES: u64 = 4 << 20;

/// Opens and checks a pack.
pub fn open_pack(path: &Path) -> Result<Pack> {
    Pack::open(path).map_err(|source| {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        let is_other = matches!(&source, crowd_pack::Error::Format { place, .. } if place.starts_with("header"));
        let is_asset = is_other && ["glb", "gltf", "obj", "toml"].contains(&ending.as_str());
        let path = path.to_owned();
        if is_asset { Error::NotBaked { path } } else { Error::Pack { path, source } }
    })
}

/// Makes the crowd: decodes textures, resolves names, places instances. `aspect`: width over height of the picture.
///
/// # Errors
/// [`Error::Parameter`] for a character or clip the pack does not have, [`Error::Scene`] for a refused layout file.
pub fn gather(pack: &Pack, plan: &CrowdPlan, aspect: f32) -> Result<Crowd> {
    // What nobody will be takes neither time nor memory.
    let mut data = match plan.impostors {
        ImpostorsPlan::Off => CrowdData::without_impostors(pack, plan.texture_side)?,
        _ => CrowdData::from_pack(pack, plan.texture_side)?,
    };
    let lacks_impostors = plan.impostors == ImpostorsPlan::Asked && data.impostors.is_none();
    if plan.measures_speeds {
        data.clip_speeds = cpu::clip_speeds(&data);
    }
    let manifest = &pack.contents().manifest.characters;
    let mut characters = choose_characters(manifest, &plan.characters)?;
    let mut remarks = Vec::new();
    if lacks_impostors {
        remarks.push("this pack has no impostors (--impostors); crowdbake bake --impostors 16 makes some".to_owned());
    }
    let mut clips = choose_clips(manifest, &characters, &plan.clips, &mut remarks)?;
    let mut factors = choose_factors(&data, manifest, &characters, &plan.height, &mut remarks)?;
    if plan.layout == LayoutPlan::Named(Layout::Seats) && plan.clips == ClipPlan::Usual {
        clips = seated(manifest, &characters, clips);
    }
    let names_of = |c: u32| -> Vec<&str> { manifest[c as usize].clips.iter().map(|clip| clip.name.as_str()).collect() };
    let mut kinds: Vec<Kind> = (0..characters.len())
        .map(|k| Kind {
            name: manifest[characters[k] as usize].name.clone(),
            clip_names: names_of(characters[k]).into_iter().map(str::to_owned).collect(),
            ..kind(&data, characters[k], &clips[k], factors[k])
        })
        .collect();
    if matches!(plan.layout, LayoutPlan::Feed(FeedPlan::Trajectories { .. } | FeedPlan::Walk { .. })) {
        let stays = who_walks(&kinds, !plan.characters.is_empty(), &mut remarks);
        (characters, clips) = (kept(characters, &stays), kept(clips, &stays));
        (factors, kinds) = (kept(factors, &stays), kept(kinds, &stays));
    }

    let mut moving = None;
    let (placed, spacing_m) = match &plan.layout {
        LayoutPlan::Named(layout) => {
            let asked_m = plan.spacing_m.unwrap_or_else(|| usual_spacing(&kinds));
            let spacing_m = crowd_scene::spacing_used(*layout, asked_m, &kinds);
            remarks.extend(plan.spacing_m.and_then(|asked_m| raised(asked_m, spacing_m, &kinds)));
            (crowd_scene::place(*layout, plan.count, spacing_m, &kinds, &clips, plan.seed), spacing_m)
        }
        LayoutPlan::File(path) => (read_layout(path, &kinds, &clips)?, 0.0),
        LayoutPlan::Feed(feed) => {
            let movers = (0..characters.len()).map(|k| {
                let mover = mover(&data, characters[k], &names_of(characters[k]), &clips[k], factors[k]);
                with_root_paths(mover, &manifest[characters[k] as usize].clips)
            });
            let cast = Cast { movers: movers.collect(), seed: plan.seed, fade_s: plan.fade_s };
            let radius_m = |id: u32| {
                let traits = cast.traits_of(id);
                kinds[traits.mover as usize].footprint_m * traits.scale
            };
            let feed = Feed::open(feed, plan.count, plan.seed, radius_m, &mut remarks)?;
            (moving.insert(Moving::new(feed, cast)).everyone(), 0.0)
        }
    };
    let shown: Vec<(u32, f32)> = characters.iter().copied().zip(factors).collect();
    let instances: Vec<InstanceRecord> = placed.iter().map(|one| record(&data, &shown, one)).collect();
    let actors: Vec<Actor<'_>> = (0..characters.len())
        .map(|k| {
            let (character, name) = (characters[k], manifest[characters[k] as usize].name.as_str());
            Actor { character, name, clip_names: names_of(character), clips: &clips[k] }
        })
        .collect();
    let schedules = Schedules::open(&plan.motion, &data, &actors, &instances, plan.seed, &mut remarks)?;
    let mut bounds = bounds(&data, &instances);
    let framed = match &moving {
        Some(moving) => {
            let (low, high) = moving.extent();
            (bounds.min, bounds.max) = (bounds.min.min(low), bounds.max.max(high));
            crowd_scene::overlook(bounds.min, bounds.max, aspect)
        }
        // Rings that rise around a stage are seen from above, or the nearest would hide the others.
        None if plan.layout == LayoutPlan::Named(Layout::Seats) => {
            // They are round: their box would have empty corners.
            let inwards = Vec3::new(ROUND, 1.0, ROUND);
            crowd_scene::overlook(bounds.min * inwards, bounds.max * inwards, aspect)
        }
        None => crowd_scene::frame_crowd(&placed, bounds.height_m, aspect),
    };
    let summary = summary(&data, manifest, &characters, &clips, &instances, spacing_m, plan.seed);
    let mut scenery = match &plan.walkable {
        Some(path) => read_walkable(path)?,
        None => moving.as_ref().map_or(Ok(Scenery::default()), Moving::scenery)?,
    };
    if plan.layout == LayoutPlan::Named(Layout::Seats) {
        scenery.add_steps(&crowd_scene::seat_steps(plan.count, spacing_m, &kinds));
    }
    let simulator = plan.simulator;
    Ok(Crowd { data, instances, summary, bounds, framed, remarks, moving, schedules, scenery, simulator, shown })
}

fn read_layout(path: &Path, kinds: &[Kind], clips: &[Vec<u32>]) -> Result<Vec<Instance>> {
    let refused = |problem: String| Error::Scene { path: path.to_owned(), problem };
    let people =
        crowd_scene::parse_layout(&read_text(path, LAYOUT_BYTES)?, kinds, clips).map_err(|e| refused(e.to_string()))?;
    if people.is_empty() {
        return Err(refused("found nobody, allowed at least one line with a person".to_owned()));
    }
    Ok(people)
}

fn read_walkable(path: &Path) -> Result<Scenery> {
    let refused = |e: crowd_scene::Error| Error::Scene { path: path.to_owned(), problem: e.to_string() };
    let area = WalkableArea::parse(&read_text(path, WALKABLE_BYTES)?).map_err(refused)?;
    Scenery::of_area(&area).map_err(refused)
}

fn choose_characters(manifest: &[ManifestCharacter], names: &[String]) -> Result<Vec<u32>> {
    if names.is_empty() {
        return Ok((0..manifest.len() as u32).collect());
    }
    let mut chosen = Vec::new();
    for name in names {
        let exact = manifest.iter().position(|c| c.name == *name);
        let found = exact.or_else(|| manifest.iter().position(|c| c.name.eq_ignore_ascii_case(name)));
        let index = found.ok_or_else(|| Error::Parameter {
            option: "--characters",
            found: name.clone(),
            allowed: list(manifest.iter().map(|c| c.name.as_str())),
        })?;
        if !chosen.contains(&(index as u32)) {
            chosen.push(index as u32);
        }
    }
    Ok(chosen)
}

/// The clips of each chosen character that may play, as indices within the character.
fn choose_clips(
    manifest: &[ManifestCharacter],
    characters: &[u32],
    plan: &ClipPlan,
    remarks: &mut Vec<String>,
) -> Result<Vec<Vec<u32>>> {
    let names_of = |c: u32| -> Vec<&str> { manifest[c as usize].clips.iter().map(|c| c.name.as_str()).collect() };
    if let ClipPlan::Named(words) = plan {
        for word in words {
            if characters.iter().all(|&c| named(&names_of(c), word).is_empty()) {
                let mut seen = std::collections::BTreeSet::new();
                let all = characters.iter().flat_map(|&c| names_of(c)).filter(|name| seen.insert(*name));
                let allowed = list(all);
                return Err(Error::Parameter { option: "--clips", found: word.clone(), allowed });
            }
        }
    }
    let mut chosen = Vec::with_capacity(characters.len());
    // What is said of the choice, and of whom: characters of one rig choose alike.
    let mut partial: Vec<(String, Vec<&str>)> = Vec::new();
    for &character in characters {
        let names = names_of(character);
        let all = || (0..names.len().max(1) as u32).collect::<Vec<u32>>();
        let clips = match plan {
            ClipPlan::All => all(),
            ClipPlan::Usual => usual_clips(&names),
            ClipPlan::Named(words) => {
                let mut found: Vec<u32> = words.iter().flat_map(|word| named(&names, word)).collect();
                found.sort_unstable();
                found.dedup();
                if found.is_empty() {
                    found = usual_clips(&names);
                    remarks
                        .push(format!("{}: none of --clips; plays its usual ones", manifest[character as usize].name));
                }
                found
            }
        };
        if *plan == ClipPlan::Usual && clips.len() < names.len() {
            let some = list(clips.iter().map(|&c| names[c as usize]));
            let sentence = format!("of {} clips {} (--clips all for all)", names.len(), some);
            match partial.iter_mut().find(|(said, _)| *said == sentence) {
                Some((_, who)) => who.push(&manifest[character as usize].name),
                None => partial.push((sentence, vec![&manifest[character as usize].name])),
            }
        }
        chosen.push(clips);
    }
    remarks.extend(partial.into_iter().map(|(sentence, who)| format!("{}: {sentence}", list(who))));
    Ok(chosen)
}

/// The clips of an audience: those in which a character sits, or else those in which it does not go anywhere.
fn seated(manifest: &[ManifestCharacter], characters: &[u32], clips: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
    let of = |(&character, usual): (&u32, Vec<u32>)| {
        let names: Vec<&str> = manifest[character as usize].clips.iter().map(|clip| clip.name.as_str()).collect();
        let choices = ["sit", "idle", "stand"].map(|word| named(&names, word));
        choices.into_iter().find(|found| !found.is_empty()).unwrap_or(usual)
    };
    characters.iter().zip(clips).map(of).collect()
}

/// Clips called `word`, or else those whose name contains it; case does not count.
fn named(names: &[&str], word: &str) -> Vec<u32> {
    let pick = |rule: &dyn Fn(&str) -> bool| -> Vec<u32> {
        (0..names.len() as u32).filter(|&i| rule(names[i as usize])).collect()
    };
    let exact = pick(&|name| name.eq_ignore_ascii_case(word));
    let word = word.to_lowercase();
    if exact.is_empty() { pick(&|name| name.to_lowercase().contains(&word)) } else { exact }
}

/// Words in the names of clips that nobody in a crowd plays unasked.
pub(crate) const UNUSUAL_CLIPS: [&str; 22] = [
    "melee", "aim", "shoot", "block", "gun", "jump", "lie", "lying", "sit", "fall", "death", "dead", "swim", "climb",
    "crawl", "back", "strafe", "left", "right", "fly", "attack", "hold",
];

/// What a crowd does when nobody says what it shall do: of many clips those called idle, walk or run, standing on the
/// ground and going forward; never a T-pose if there is anything else.
fn usual_clips(names: &[&str]) -> Vec<u32> {
    const USUAL: [&str; 3] = ["idle", "walk", "run"];
    let lower: Vec<String> = names.iter().map(|name| name.to_lowercase()).collect();
    let pick = |rule: &dyn Fn(&str) -> bool| -> Vec<u32> {
        (0..lower.len() as u32).filter(|&i| rule(&lower[i as usize])).collect()
    };
    let plain: String = String::from("tpose");
    let pose = |name: &str| {
        let letters: String = name.chars().filter(|c| c.is_alphanumeric()).collect();
        letters.contains(&plain) || letters.contains("apose") || letters.contains("bindpose")
    };
    let usual = |name: &str| USUAL.iter().any(|word| name.contains(word)) && !pose(name);
    let calm = |name: &str| usual(name) && !UNUSUAL_CLIPS.iter().any(|word| name.contains(word));
    let choices = if names.len() > 3 { [pick(&calm), pick(&usual)] } else { [Vec::new(), Vec::new()] };
    let moving = pick(&|name| !pose(name));
    let all: Vec<u32> = (0..names.len().max(1) as u32).collect();
    choices.into_iter().chain([moving]).find(|found| !found.is_empty()).unwrap_or(all)
}

/// From this height on a character is taken to be drawn in centimetres: no building, no dinosaur walks in a crowd.
const CENTIMETRES_FROM_M: f32 = 20.0;

/// The factor each character is shown with.
fn choose_factors(
    data: &CrowdData,
    manifest: &[ManifestCharacter],
    characters: &[u32],
    plan: &HeightPlan,
    remarks: &mut Vec<String>,
) -> Result<Vec<f32>> {
    let names = || characters.iter().map(|&c| manifest[c as usize].name.as_str());
    if let HeightPlan::Named(some) = plan
        && let Some((unknown, _)) = some.iter().find(|(name, _)| !names().any(|n| n.eq_ignore_ascii_case(name)))
    {
        return Err(Error::Parameter { option: "--height", found: unknown.clone(), allowed: list(names()) });
    }
    let mut factors = Vec::with_capacity(characters.len());
    for (&character, name) in characters.iter().zip(names()) {
        let baked_m = data.characters[character as usize].height_m;
        let asked_m = match plan {
            HeightPlan::All(metres) => Some(*metres),
            HeightPlan::Named(some) => some.iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|&(_, m)| m),
            HeightPlan::Usual | HeightPlan::Source => None,
        };
        factors.push(match asked_m {
            Some(metres) if baked_m > 0.0 => metres / baked_m,
            None if *plan != HeightPlan::Source && baked_m >= CENTIMETRES_FROM_M => {
                remarks.push(format!(
                    "{name}: {baked_m:.1} m high as baked, taken for centimetres and shown at 1/100 (--height source for as baked)"
                ));
                0.01
            }
            _ => 1.0,
        });
    }
    Ok(factors)
}

fn bounds(data: &CrowdData, instances: &[InstanceRecord]) -> Bounds {
    let (mut min, mut max, mut height_m) = (Vec3::MAX, Vec3::MIN, 0.0f32);
    for one in instances {
        let feet = Vec3::from_array(one.position);
        let height = data.characters[one.character as usize].height_m * one.scale;
        min = min.min(feet);
        max = max.max(feet + Vec3::Y * height);
        height_m = height_m.max(height);
    }
    Bounds { min, max, height_m }
}

fn summary(
    data: &CrowdData,
    manifest: &[ManifestCharacter],
    characters: &[u32],
    clips: &[Vec<u32>],
    instances: &[InstanceRecord],
    spacing_m: f32,
    seed: u32,
) -> stats::Crowd {
    let of = |one: &InstanceRecord| &data.characters[one.character as usize];
    let clip_name = |c: u32, i: u32| {
        let character = &manifest[c as usize];
        let clip = character.clips.get(i as usize).map_or("rest", |clip| clip.name.as_str());
        format!("{}/{clip}", character.name)
    };
    stats::Crowd {
        instances: instances.len() as u32,
        characters: characters.iter().map(|&c| manifest[c as usize].name.clone()).collect(),
        clips: characters
            .iter()
            .zip(clips)
            .flat_map(|(&c, clips)| clips.iter().map(move |&i| clip_name(c, i)))
            .collect(),
        vertices_full: instances.iter().map(|one| u64::from(of(one).vertex_count)).sum(),
        vertices_least: instances.iter().map(|one| u64::from(of(one).min_vertex_count)).sum(),
        triangles_full: instances.iter().map(|one| u64::from(of(one).triangle_count)).sum(),
        spacing_m,
        seed,
    }
}

/// Names with commas between, the first twelve.
pub(crate) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let shown = names.iter().take(12).copied().collect::<Vec<_>>().join(", ");
    if names.len() > 12 { format!("{shown} and {} more", names.len() - 12) } else { shown }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen<'a>(names: &[&'a str]) -> Vec<&'a str> {
        usual_clips(names).into_iter().map(|i| names[i as usize]).collect()
    }

    #[test]
    fn of_many_clips_the_calm_ones_on_the_ground_play() {
        let names =
            ["1H_Attack", "Idle", "Jump_Idle", "Lie_Idle", "Running_A", "Running_Strafe_Left", "T-Pose", "Walking_A"];
        assert_eq!(chosen(&names), ["Idle", "Running_A", "Walking_A"]);
    }

    #[test]
    fn of_few_clips_all_play_but_a_t_pose() {
        assert_eq!(chosen(&["Survey", "Walk", "Run"]), ["Survey", "Walk", "Run"]);
        assert_eq!(chosen(&["T_Pose", "Wave"]), ["Wave"]);
        assert_eq!(chosen(&["idle", "run", "sit", "walk"]), ["idle", "run", "walk"], "nobody sits on air");
        assert_eq!(chosen(&["TPose"]), ["TPose"]);
        assert_eq!(usual_clips(&[]), [0]);
    }

    #[test]
    fn without_a_usual_clip_all_but_the_pose_play() {
        assert_eq!(chosen(&["a", "b", "c", "d", "T-Pose"]), ["a", "b", "c", "d"]);
        assert_eq!(chosen(&["Sit_Idle", "b", "c", "d", "e"]), ["Sit_Idle"]);
    }

    #[test]
    fn a_name_is_taken_whole_before_it_is_taken_as_a_part() {
        assert_eq!(named(&["Walk", "Walk_Fast"], "walk"), [0]);
        assert_eq!(named(&["Walking_A", "Walking_B", "Run"], "WALK"), [0, 1]);
    }

    #[test]
    fn unknown_names_are_answered_with_the_known() {
        let ada = ManifestCharacter { name: "Ada".into(), ..Default::default() };
        let error = choose_characters(std::slice::from_ref(&ada), &["Bob".into()]).unwrap_err();
        assert_eq!(error.to_string(), "--characters: found Bob, allowed Ada");
        assert_eq!(choose_characters(&[ada], &["ada".into()]).unwrap(), [0]);
    }
}
