// In which cell everyone of a flock is. Twin: crowd-stages/src/cpu/cell_boids.rs.

@group(0) @binding(0) var<uniform> flock: FlockConfig;
@group(0) @binding(1) var<storage, read> boids: array<BoidRecord>;
@group(0) @binding(2) var<storage, read_write> cells: array<u32>;

@compute @workgroup_size(BLOCK_SIZE)
fn cell_boids(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= flock.boid_count {
        return;
    }
    let cell = cell_at(boids[i].place);
    cells[i] = u32(cell.y) * flock.columns + u32(cell.x);
}
