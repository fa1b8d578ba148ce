// A step of everyone of a flock by Reynolds' three rules (1987), the rim of the place and others' bodies. A thread a boid, in the
// order of cells; everyone looks at the sorted copies, which are the state before the step. Twin:
// crowd-stages/src/cpu/steer_boids.rs.

@group(0) @binding(0) var<uniform> flock: FlockConfig;
@group(0) @binding(1) var<storage, read> sorted_numbers: array<u32>;
@group(0) @binding(2) var<storage, read> sorted_boids: array<SortedBoid>;
@group(0) @binding(3) var<storage, read> starts: array<u32>;
@group(0) @binding(4) var<storage, read_write> boids: array<BoidRecord>;

const TAU: f32 = 6.2831855;

// The own cell first.
const CELLS = array<vec2i, 9>(
    vec2i(0, 0), vec2i(0, -1), vec2i(-1, 0), vec2i(1, 0), vec2i(0, 1),
    vec2i(-1, -1), vec2i(1, -1), vec2i(-1, 1), vec2i(1, 1),
);

struct Steering {
    pull: vec2f,
    push: vec2f,
}

fn at_most(v: vec2f, most: f32) -> vec2f {
    let square = dot(v, v);
    if square > most * most {
        return most * (v / sqrt(square));
    }
    return v;
}

fn direction_or(v: vec2f, other: vec2f) -> vec2f {
    let size = sqrt(dot(v, v));
    if size > 1e-37 {
        return v * (1.0 / size);
    }
    return other;
}

// Within -pi to pi.
fn wrapped(yaw_rad: f32) -> f32 {
    let turns = yaw_rad / TAU;
    return (turns - floor(turns + 0.5)) * TAU;
}

fn gait_at(before: u32, speed: f32) -> u32 {
    let stands_below = select(flock.stands_below_m_s.x, flock.stands_below_m_s.y, before == 0u);
    let runs_from = select(flock.runs_from_m_s.y, flock.runs_from_m_s.x, before == 2u);
    if speed < stands_below {
        return 0u;
    }
    return select(2u, 1u, speed < runs_from);
}

// An acceleration, and out of others' bodies, metres.
fn steering(me: SortedBoid, number: u32) -> Steering {
    var apart = vec2f(0.0);
    var push = vec2f(0.0);
    var velocities = vec2f(0.0);
    var places = vec2f(0.0);
    var count = 0u;
    let own = cell_at(me.place);
    var cells = CELLS;
    for (var c = 0u; c < 9u; c++) {
        let cell = own + cells[c];
        if any(cell < vec2i(0)) || cell.x >= i32(flock.columns) || cell.y >= i32(flock.rows) {
            continue;
        }
        let index = u32(cell.y) * flock.columns + u32(cell.x);
        let end = starts[index + 1u];
        for (var k = starts[index]; k < end; k++) {
            let other = sorted_boids[k];
            let away = me.place - other.place;
            let distance = sqrt(dot(away, away));
            if distance > flock.sight_m {
                continue;
            }
            let other_number = sorted_numbers[k];
            if other_number == number {
                continue;
            }
            if count < flock.most_followed {
                count += 1u;
                velocities += other.velocity;
                places += other.place;
            }
            // As if both were as wide as a person.
            let near = distance - (me.wider_m + other.wider_m);
            if near < flock.apart_m {
                // Two in one spot part by their numbers.
                let sideways = vec2f(select(-1.0, 1.0, other_number < number), 0.0);
                let direction = direction_or(away, sideways);
                apart += direction * min(flock.apart_m / max(near, 0.05) - 1.0, 8.0);
                push += direction * (0.5 * max(flock.bodies_m - near, 0.0));
            }
        }
    }
    var pull = flock.separation * apart;
    if count > 0u {
        let mean = 1.0 / f32(count);
        pull += flock.alignment * (velocities * mean - me.velocity);
        pull += flock.cohesion * (places * mean - me.place);
    }
    let beyond = sqrt(dot(me.place, me.place)) - flock.radius_m * flock.rim;
    if beyond > 0.0 {
        // Inwards, and around rather than straight back.
        let inwards = direction_or(-me.place, vec2f(0.0, 1.0));
        let left = vec2f(-inwards.y, inwards.x);
        let turns_right = inwards.x * me.velocity.y - inwards.y * me.velocity.x < 0.0;
        pull += (inwards + 0.6 * select(left, -left, turns_right)) * (1.0 + beyond);
    }
    return Steering(pull, push);
}

@compute @workgroup_size(INSTANCE_GROUP_SIZE)
fn steer_boids(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let k = group_number(workgroup) * INSTANCE_GROUP_SIZE + lane;
    if k >= flock.boid_count {
        return;
    }
    let number = sorted_numbers[k];
    let steered = steering(sorted_boids[k], number);
    var boid = boids[number];
    var velocity = boid.velocity + at_most(steered.pull, flock.most_m_s2) * flock.step_s;
    // Back to the pace this one likes.
    var speed = sqrt(dot(velocity, velocity));
    speed = clamp(speed + (boid.pace_m_s - speed) * 0.5 * flock.step_s, flock.speed_m_s.x, flock.speed_m_s.y);
    boid.velocity = direction_or(velocity, vec2f(0.0, 1.0)) * speed;
    boid.place += boid.velocity * flock.step_s + at_most(steered.push, flock.most_push_m);
    boid.walked_m += speed * flock.step_s;
    boid.ran_m += select(0.0, speed * flock.step_s, boid.gait == 2u);
    let goal = atan2(boid.velocity.x, boid.velocity.y);
    boid.yaw_rad = wrapped(boid.yaw_rad + wrapped(goal - boid.yaw_rad) * min(flock.turn_hz * flock.step_s, 1.0));
    boid.changed_s += flock.step_s;
    let gait = gait_at(boid.gait, speed);
    if gait != boid.gait && boid.changed_s >= flock.shortest_gait_s {
        boid.gait_before = boid.gait;
        boid.gait = gait;
        boid.changed_s = 0.0;
    }
    boids[number] = boid;
}
