// Where each cell's boids begin in the sorted list, and what neighbours need to know of them, side by side.
// Twin: crowd-stages/src/cpu/fill_cells.rs.

@group(0) @binding(0) var<uniform> flock: FlockConfig;
@group(0) @binding(1) var<storage, read> boids: array<BoidRecord>;
@group(0) @binding(2) var<storage, read> sorted_cells: array<u32>;
@group(0) @binding(3) var<storage, read> sorted_numbers: array<u32>;
// One for each cell, and the end.
@group(0) @binding(4) var<storage, read_write> starts: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted_boids: array<SortedBoid>;

// The first place in the sorted list whose cell is not before this one.
fn first_of(cell: u32) -> u32 {
    var low = 0u;
    var high = flock.boid_count;
    while low < high {
        let middle = (low + high) / 2u;
        if sorted_cells[middle] < cell {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

@compute @workgroup_size(BLOCK_SIZE)
fn fill_cells(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i <= flock.columns * flock.rows {
        starts[i] = first_of(i);
    }
    if i < flock.boid_count {
        let boid = boids[sorted_numbers[i]];
        sorted_boids[i] = SortedBoid(boid.place, boid.velocity, boid.wider_m, 0u);
    }
}
