// Inclusive prefix sums over the lanes of a group of BLOCK_SIZE.

// The square root of a block.
const SCAN_RUN: u32 = 16u;

// A number of each lane.
var<workgroup> lanes: array<u32, BLOCK_SIZE>;
var<workgroup> run_bases: array<u32, SCAN_RUN>;

// Sums `lanes` in runs of sixteen, then those runs: a barrier costs more than a few additions. `sum_up_to` says what came out.
fn scan_group(lane: u32) {
    workgroupBarrier();
    if lane < SCAN_RUN {
        var sum = 0u;
        for (var i = lane * SCAN_RUN; i < lane * SCAN_RUN + SCAN_RUN; i++) {
            sum = saturating_add(sum, lanes[i]);
            lanes[i] = sum;
        }
    }
    workgroupBarrier();
    if lane == 0u {
        var sum = 0u;
        for (var r = 0u; r < SCAN_RUN; r++) {
            run_bases[r] = sum;
            sum = saturating_add(sum, lanes[r * SCAN_RUN + SCAN_RUN - 1u]);
        }
    }
    workgroupBarrier();
}

// After scan_group: the sum of all lanes up to this one.
fn sum_up_to(lane: u32) -> u32 {
    return saturating_add(run_bases[lane / SCAN_RUN], lanes[lane]);
}

// The same of those before it.
fn sum_before(lane: u32) -> u32 {
    return select(sum_up_to(max(lane, 1u) - 1u), 0u, lane == 0u);
}
