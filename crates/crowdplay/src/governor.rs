//! Moves the budget N so that frames take a given time: down at once, up with patience, and not at all in between.

/// Part of the target below which a frame has time to spare.
const SPARE: f32 = 0.85;
/// What is aimed at, so that small changes of the view do not go over the target.
const AIM: f32 = 0.95;
/// Frames that are looked at together: one that took long for other reasons does not count.
const WINDOW: usize = 3;
/// Frames after a change whose times may still be those of the old budget.
const LATE: u32 = 2;
/// Windows of frames with time to spare before the budget rises.
const PATIENCE: u32 = 3;
/// Most that the budget falls or rises at once.
const STEPS: [f32; 2] = [0.5, 1.25];

/// The budget and what is known of its times.
#[derive(Debug, Clone)]
pub struct Governor {
    target_ms: f32,
    budget: u32,
    most: u32,
    times_ms: Vec<f32>,
    /// Of the newest frames looked at together.
    median_ms: f32,
    late: u32,
    spare_windows: u32,
}

impl Governor {
    /// Vertices that stay whatever the time.
    pub const LEAST: u32 = 1_000;

    /// `target_ms`: what a frame may take. Begins at `budget`; never goes above `most`.
    pub fn new(target_ms: f32, budget: u32, most: u32) -> Self {
        let most = most.max(Self::LEAST);
        let budget = budget.clamp(Self::LEAST, most);
        Self { target_ms, budget, most, times_ms: Vec::new(), median_ms: 0.0, late: 0, spare_windows: 0 }
    }

    /// The budget for the next frame, after one that took `frame_ms`.
    pub fn next(&mut self, frame_ms: f32) -> u32 {
        if self.late > 0 {
            self.late -= 1;
            return self.budget;
        }
        self.times_ms.push(frame_ms);
        if self.times_ms.len() < WINDOW {
            return self.budget;
        }
        self.times_ms.sort_by(f32::total_cmp);
        let median_ms = self.times_ms[WINDOW / 2].max(1e-3);
        self.median_ms = median_ms;
        self.times_ms.clear();
        let has_spare = median_ms < SPARE * self.target_ms;
        self.spare_windows = if has_spare { self.spare_windows + 1 } else { 0 };
        if median_ms > self.target_ms || self.spare_windows >= PATIENCE {
            self.change(AIM * self.target_ms / median_ms);
        }
        self.budget
    }

    fn change(&mut self, factor: f32) {
        let wanted = self.budget as f32 * factor.clamp(STEPS[0], STEPS[1]);
        self.budget = (wanted as u32).clamp(Self::LEAST, self.most);
        (self.late, self.spare_windows) = (LATE, 0);
    }

    /// What is wrong when the least budget does not hold the target.
    pub fn complaint(&self) -> Option<String> {
        let is_missed = self.budget == Self::LEAST && self.median_ms > self.target_ms;
        let Self { target_ms, median_ms, .. } = self;
        is_missed.then(|| {
            format!(
                "target: {median_ms:.1} ms with the least budget ({}), {target_ms} asked for (--target-ms); use fewer instances or a smaller --size",
                Self::LEAST
            )
        })
    }

    /// The same budget with another target.
    pub fn aim_at(&mut self, target_ms: f32) {
        self.target_ms = target_ms;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Budgets over frames that cost `fixed_ms` and so much more for each thousand vertices, with every tenth frame held up.
    fn govern(governor: &mut Governor, fixed_ms: f32, ms_a_thousand: f32, frames: u32) -> Vec<u32> {
        let mut budget = governor.budget;
        let frame = |number: u32| {
            let wobble = 1.0 + 0.03 * ((number * 7 % 5) as f32 - 2.0) / 2.0;
            let held_up = if number % 10 == 9 { 40.0 } else { 0.0 };
            budget = governor.next((fixed_ms + budget as f32 * 1e-3 * ms_a_thousand) * wobble + held_up);
            budget
        };
        (0..frames).map(frame).collect()
    }

    #[test]
    fn a_target_is_reached_from_both_sides_and_held() {
        for start in [2_000, 5_000_000] {
            let mut governor = Governor::new(20.0, start, 8_000_000);
            let budgets = govern(&mut governor, 4.0, 0.02, 600);
            // 16 ms for vertices are 800,000; the dead band is 650,000 to 800,000.
            let last = &budgets[400..];
            assert!(last.iter().all(|budget| (620_000..=800_000).contains(budget)), "{start}: {last:?}");
            assert!(last.windows(2).filter(|pair| pair[0] != pair[1]).count() <= 2, "it comes to rest");
        }
    }

    #[test]
    fn it_follows_a_dearer_view_within_a_second_and_comes_back() {
        let mut governor = Governor::new(20.0, 700_000, 8_000_000);
        govern(&mut governor, 4.0, 0.02, 100);
        let dear = govern(&mut governor, 4.0, 0.08, 60);
        assert!(*dear.last().unwrap() <= 200_000, "{dear:?}");
        let cheap = govern(&mut governor, 4.0, 0.02, 400);
        assert!(*cheap.last().unwrap() > 600_000, "{cheap:?}");
    }

    #[test]
    fn a_target_out_of_reach_leaves_the_least_and_one_never_met_the_most() {
        let mut governor = Governor::new(5.0, 700_000, 2_000_000);
        assert_eq!(govern(&mut governor, 9.0, 0.02, 300).last(), Some(&Governor::LEAST));
        assert!(governor.complaint().expect("9 ms are more than 5").contains("--target-ms"));
        let mut governor = Governor::new(500.0, 700_000, 2_000_000);
        assert_eq!(govern(&mut governor, 9.0, 0.02, 300).last(), Some(&2_000_000));
        assert_eq!(governor.complaint(), None);
    }
}
