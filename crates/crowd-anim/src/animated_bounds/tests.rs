use super::*;
use proptest::prelude::*;

const IDENTITY: Mat3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

fn moved(x: f32) -> Mat3x4 {
    let mut matrix = IDENTITY;
    matrix[0][3] = x;
    matrix
}

fn holds(bounds: &Bounds, point: [f32; 3]) -> bool {
    let in_box = (0..3).all(|axis| (bounds.min[axis]..=bounds.max[axis]).contains(&point[axis]));
    in_box && squared_distance(bounds.center, point).sqrt() <= bounds.radius
}

#[test]
fn a_point_on_its_way_is_held_where_it_was_and_where_it_goes() {
    let joints = [[0, 0, 0, 0]];
    let weights = [[1.0, 0.0, 0.0, 0.0]];
    let bounds = animated_bounds(&[[0.0, 1.0, 0.0]], &joints, &weights, &[moved(-2.0), moved(4.0)], 1);
    assert!(holds(&bounds, [-2.0, 1.0, 0.0]) && holds(&bounds, [4.0, 1.0, 0.0]) && holds(&bounds, [1.0, 1.0, 0.0]));
    assert!((bounds.radius - 3.0).abs() < 1e-3 && (bounds.center[0] - 1.0).abs() < 1e-3);
    // The comparator can fail.
    assert!(!holds(&bounds, [4.1, 1.0, 0.0]) && !holds(&bounds, [1.0, 1.01, 0.0]));
}

#[test]
fn the_sphere_of_a_corner_triangle_is_not_the_boxs() {
    // Three corners of a unit cube: the box's centre gives radius sqrt(3)/2 = 0.866, the best is sqrt(2/3) = 0.816.
    let points = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let bounds = animated_bounds(&points, &[], &[], &[], 0);
    assert!(bounds.radius < 0.822, "{}", bounds.radius);
    assert!(points.iter().all(|&p| holds(&bounds, p)));
}

#[test]
fn a_vertex_is_the_weighted_sum_of_its_joints_places() {
    // Peng 2011, Eq. 2: a quarter of the way from where joint 0 takes it to where joint 1 does.
    let quarter_turn = [[0.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 8.0]];
    let point = skin([4.0, 2.0, 0.0], &[0, 1, 0, 0], &[0.75, 0.25, 0.0, 0.0], &[IDENTITY, quarter_turn]);
    assert_eq!(point, [3.0, 2.0, 1.0]);
}

#[test]
fn nothing_and_nonsense_give_empty_bounds() {
    assert_eq!(animated_bounds(&[], &[], &[], &[], 3), Bounds::default());
    assert_eq!(animated_bounds(&[[f32::NAN; 3]], &[], &[], &[], 0), Bounds::default());
    assert_eq!(union_bounds(&[]), Bounds::default());
    let far = [[99, 0, 0, 0]];
    let bounds = animated_bounds(&[[5.0; 3]], &far, &[[1.0, 0.0, 0.0, 0.0]], &[IDENTITY], 1);
    assert_eq!(bounds.center, [0.0; 3]);
}

#[test]
fn a_ball_inside_another_adds_nothing() {
    let cube = |half: f32| animated_bounds(&[[-half; 3], [half; 3]], &[], &[], &[], 0);
    let both = union_bounds(&[cube(1.0), cube(2.0)]);
    assert!((both.radius - cube(2.0).radius).abs() < 1e-5);
    assert_eq!(union_bounds(&[cube(2.0)]), cube(2.0));
}

proptest! {
    #[test]
    fn every_vertex_of_every_frame_is_held(
        vertices in prop::collection::vec((prop::array::uniform3(-3.0_f32..3.0), prop::array::uniform4(0_u16..3), 0.0_f32..1.0), 1..20),
        matrices in prop::collection::vec(prop::array::uniform3(prop::array::uniform4(-2.0_f32..2.0)), 12),
        halfway in 0.0_f32..1.0,
    ) {
        let positions: Vec<_> = vertices.iter().map(|v| v.0).collect();
        let joints: Vec<_> = vertices.iter().map(|v| v.1).collect();
        let weights: Vec<_> = vertices.iter().map(|v| [v.2, 1.0 - v.2, 0.0, 0.0]).collect();
        let whole = animated_bounds(&positions, &joints, &weights, &matrices, 3);
        let halves = [&matrices[..6], &matrices[6..]].map(|m| animated_bounds(&positions, &joints, &weights, m, 3));
        let united = union_bounds(&halves);
        for (number, frame) in matrices.chunks(3).enumerate() {
            for i in 0..positions.len() {
                let point = skin(positions[i], &joints[i], &weights[i], frame);
                prop_assert!(holds(&whole, point) && holds(&united, point) && holds(&halves[number / 2], point));
            }
        }
        // Between frames the matrices are blended.
        let blend: Vec<Mat3x4> = (0..3).map(|j| {
            [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| matrices[j][r][c] * (1.0 - halfway) + matrices[j + 3][r][c] * halfway))
        }).collect();
        for i in 0..positions.len() {
            prop_assert!(holds(&whole, skin(positions[i], &joints[i], &weights[i], &blend)));
        }
        // Never worse than the box's own sphere.
        let half_diagonal = squared_distance(whole.min, whole.max).sqrt() / 2.0;
        prop_assert!(whole.radius <= half_diagonal * 1.001);
    }
}
