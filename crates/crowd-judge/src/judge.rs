//! Prepares an original once and judges its levels.

use crate::nearest::{PosedSurface, TreeShape};
use crate::pictures::{self, PICTURED_POSES, Painted, Picture, PictureSums, VIEWS};
use crate::pose::{pose_normals, pose_positions};
use crate::spread::{SurfacePoint, spread_points};
use crate::verdict::{PoseFindings, sum_up};
use crate::{Error, JudgeOptions, JudgedPoses, Level, Mat3x4, Paint, Result, SkinnedMesh, Verdict};
use crowd_raster::{View, sample};
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

/// How much further away than the nearest point another chart may lie and still count, as a share of the diagonal.
const SEAM_SLACK: f64 = 0.001;

/// An original, ready to judge its levels.
#[derive(Debug)]
pub struct Judge {
    original: Side,
    paint: Paint,
    /// At rest, then in motion.
    poses: Vec<Vec<Mat3x4>>,
    diagonal_m: f64,
    options: JudgeOptions,
    shots: Vec<Shot>,
}

/// A picture of the original, and what it takes to draw one of a level.
#[derive(Debug)]
struct Shot {
    /// Index into the poses.
    pose: usize,
    view: View,
    picture: Picture,
}

/// A mesh with its points and what does not change from pose to pose.
#[derive(Debug)]
struct Side {
    mesh: SkinnedMesh,
    shape: TreeShape,
    points: Vec<SurfacePoint>,
    /// Base colour at each point, sRGB.
    colors: Vec<Vec3>,
}

/// A side in one pose.
struct PosedSide<'a> {
    side: &'a Side,
    surface: PosedSurface<'a>,
    normals: Vec<Vec3>,
}

impl Judge {
    /// Prepares an original. All levels judged must name the same joints and materials.
    ///
    /// # Errors
    /// [`Error::Parameter`] when arrays disagree in length, an index points outside, or no triangle has an area at rest.
    pub fn new(original: SkinnedMesh, paint: Paint, poses: &JudgedPoses, options: JudgeOptions) -> Result<Self> {
        let poses: Vec<Vec<Mat3x4>> = std::iter::once(&poses.rest).chain(&poses.moving).cloned().collect();
        check_mesh(&original, &paint, &poses)?;
        let at_rest = pose_positions(&original, &poses[0]);
        let used = || original.triangles.as_flattened().iter().map(|&v| at_rest[v as usize]);
        let low = used().fold(Vec3::INFINITY, Vec3::min);
        let high = used().fold(Vec3::NEG_INFINITY, Vec3::max);
        let diagonal_m = f64::from((high - low).length());
        let original = Side::new(original, &paint, &at_rest, options)?;
        let mut judge = Self { original, paint, poses, diagonal_m, options, shots: Vec::new() };
        if options.pictures {
            judge.shots = judge.take_shots();
        }
        Ok(judge)
    }

    /// Pictures of the original, from all sides.
    fn take_shots(&self) -> Vec<Shot> {
        let moving = self.poses.len() - 1;
        let spread = |i: usize| 1 + (2 * i + 1) * moving / (2 * PICTURED_POSES);
        let mut chosen: Vec<usize> = if moving == 0 { vec![0] } else { (0..PICTURED_POSES).map(spread).collect() };
        chosen.dedup();
        let mesh = &self.original.mesh;
        let painted = Painted::new(mesh);
        let wanted: Vec<(usize, u32)> =
            chosen.iter().flat_map(|&pose| (0..VIEWS).map(move |view| (pose, view))).collect();
        let take = |&(pose, view): &(usize, u32)| {
            let (positions, normals) = (pose_positions(mesh, &self.poses[pose]), pose_normals(mesh, &self.poses[pose]));
            let view = pictures::frame(&positions, &mesh.triangles, view);
            let picture = painted.draw(mesh, &self.paint, &positions, &normals, &view);
            let picture = picture.with_joints(mesh, &self.paint, &positions, &view);
            Shot { pose, view, picture }
        };
        wanted.par_iter().map(take).collect()
    }

    /// Diagonal of the original's box at rest, metres: 100 % of all distances.
    pub fn diagonal_m(&self) -> f64 {
        self.diagonal_m
    }

    /// Judges a level that has the original's skeleton. The same bits on every machine, for any number of threads.
    ///
    /// # Errors
    /// As [`Judge::new`], for the level.
    pub fn judge(&self, level: SkinnedMesh) -> Result<Verdict> {
        self.judge_level(Level { mesh: level, poses: None })
    }

    /// Judges a level that may have a skeleton of its own.
    ///
    /// # Errors
    /// As [`Judge::judge`]; and when it has not as many poses as the original.
    pub fn judge_level(&self, level: Level) -> Result<Verdict> {
        let own = level.poses.map(|poses| std::iter::once(poses.rest).chain(poses.moving).collect::<Vec<_>>());
        let poses = own.as_deref().unwrap_or(&self.poses);
        if poses.len() != self.poses.len() {
            let (found, allowed) = (poses.len().to_string(), self.poses.len().to_string());
            return Err(Error::Parameter { what: "poses", found, allowed });
        }
        check_mesh(&level.mesh, &self.paint, poses)?;
        let triangles = level.mesh.triangles.len() as u32;
        let at_rest = pose_positions(&level.mesh, &poses[0]);
        let level = Side::new(level.mesh, &self.paint, &at_rest, self.options)?;
        let judge_pose = |pose: usize| self.judge_pose(pose, &level, &poses[pose]);
        let findings: Vec<PoseFindings> = (0..poses.len()).into_par_iter().map(judge_pose).collect();
        let verdict = Verdict { triangles, ..sum_up(&findings, self.diagonal_m) };
        if self.shots.is_empty() {
            return Ok(verdict);
        }
        let seen = self.compare_pictures(&level.mesh, poses);
        Ok(Verdict {
            image_rmse: Some(seen.rmse()),
            silhouette_xor: Some(seen.silhouette_xor()),
            silhouette_missed: Some(seen.missed()),
            limbs_missed: Some(seen.missed_of_limbs()),
            ..verdict
        })
    }

    fn judge_pose(&self, pose: usize, level: &Side, palette: &[Mat3x4]) -> PoseFindings {
        let (original, level) = (PosedSide::new(&self.original, &self.poses[pose]), PosedSide::new(level, palette));
        let mut findings = PoseFindings::default();
        self.compare_points(&original, &level, &mut findings);
        self.compare_points(&level, &original, &mut findings);
        if pose == 0 {
            self.compare_texture(&original, &level, &mut findings);
            self.compare_texture(&level, &original, &mut findings);
        }
        findings
    }

    fn compare_pictures(&self, level: &SkinnedMesh, poses: &[Vec<Mat3x4>]) -> PictureSums {
        let painted = Painted::new(level);
        let compare = |shot: &Shot| {
            let palette = &poses[shot.pose];
            let (positions, normals) = (pose_positions(level, palette), pose_normals(level, palette));
            let picture = painted.draw(level, &self.paint, &positions, &normals, &shot.view);
            pictures::compare(&shot.picture, &picture)
        };
        let sums: Vec<PictureSums> = self.shots.par_iter().map(compare).collect();
        let mut total = PictureSums::default();
        sums.iter().for_each(|sum| total.add(sum));
        total
    }

    /// How far the texture slid from the points of one side to the other. Near a seam the nearest point may lie on another
    /// chart: of all faces hardly further away than the nearest one, the one with the least slide counts.
    fn compare_texture(&self, from: &PosedSide<'_>, to: &PosedSide<'_>, findings: &mut PoseFindings) {
        let slack_m = (self.diagonal_m * SEAM_SLACK) as f32;
        for point in &from.side.points {
            let material = from.side.mesh.triangle_materials[point.triangle as usize];
            let Some(texels) = texels_of(&self.paint, material) else { continue };
            let place = point.blend(from.surface.corners(point.triangle));
            let facing = from.surface.facing(point.triangle);
            let Some(nearest) = to.surface.nearest(place, Some(facing), None) else { continue };
            let uv = uv_at(&from.side.mesh, point);
            let reach = nearest.distance_squared.sqrt() + slack_m;
            let mut least = f32::INFINITY;
            to.surface.within(place, facing, reach * reach, &mut |triangle, shares| {
                if to.side.mesh.triangle_materials[triangle as usize] == material {
                    let there = uv_at(&to.side.mesh, &SurfacePoint { triangle, shares });
                    least = least.min(((there - uv) * texels).length());
                }
            });
            if least.is_finite() {
                findings.drifts.push(least);
            }
        }
    }

    /// The points of one side against the surface of the other.
    fn compare_points(&self, from: &PosedSide<'_>, to: &PosedSide<'_>, findings: &mut PoseFindings) {
        let mut guesses = (None, None);
        for (i, point) in from.side.points.iter().enumerate() {
            let place = point.blend(from.surface.corners(point.triangle));
            let Some(nearest) = to.surface.nearest(place, None, guesses.0) else { continue };
            findings.distances.push(nearest.distance_squared.sqrt());
            guesses.0 = Some(nearest.triangle);

            let facing = from.surface.facing(point.triangle);
            // Mostly the nearest face of all looks the same way.
            let alike = if facing.dot(to.surface.facing(nearest.triangle)) > 0.0 {
                Some(nearest)
            } else {
                to.surface.nearest(place, Some(facing), guesses.1)
            };
            let Some(alike) = alike else { continue };
            guesses.1 = Some(alike.triangle);
            let there = SurfacePoint { triangle: alike.triangle, shares: alike.shares };
            let (normal, other) = (from.normal_at(point, &self.paint), to.normal_at(&there, &self.paint));
            findings.add_normals(normal, other);
            let color = base_color(&to.side.mesh, &self.paint, &there);
            findings.add_colors(from.side.colors[i], color);
        }
    }
}

impl Side {
    fn new(mesh: SkinnedMesh, paint: &Paint, at_rest: &[Vec3], options: JudgeOptions) -> Result<Self> {
        let points = spread_points(at_rest, &mesh.triangles, options.points);
        if points.is_empty() {
            let found = format!("{} triangles without area", mesh.triangles.len());
            return Err(Error::Parameter { what: "surface", found, allowed: "some area".to_owned() });
        }
        let colors = points.par_iter().map(|point| base_color(&mesh, paint, point)).collect();
        let shape = TreeShape::new(at_rest, &mesh.triangles);
        Ok(Self { mesh, shape, points, colors })
    }
}

impl<'a> PosedSide<'a> {
    fn new(side: &'a Side, palette: &[Mat3x4]) -> Self {
        let positions = pose_positions(&side.mesh, palette);
        let surface = PosedSurface::new(&side.shape, &positions, &side.mesh.triangles);
        Self { side, surface, normals: pose_normals(&side.mesh, palette) }
    }

    /// The shading normal at a point, any length.
    fn normal_at(&self, point: &SurfacePoint, paint: &Paint) -> Vec3 {
        let material = self.side.mesh.triangle_materials[point.triangle as usize];
        if paint.materials[usize::from(material)].flat {
            return self.surface.facing(point.triangle);
        }
        let corners = self.side.mesh.triangles[point.triangle as usize];
        point.blend(corners.map(|v| self.normals[v as usize]))
    }
}

/// Material, texture and vertex colour at a point, sRGB-encoded, 0 to 1.
fn base_color(mesh: &SkinnedMesh, paint: &Paint, point: &SurfacePoint) -> Vec3 {
    let corners = mesh.triangles[point.triangle as usize];
    let material = &paint.materials[usize::from(mesh.triangle_materials[point.triangle as usize])];
    let share = |corner: usize| point.shares[corner];
    let blend = |of: &dyn Fn(u32) -> Vec4| (0..3).map(|c| of(corners[c]) * share(c)).sum::<Vec4>();
    let tint = blend(&|v| Vec4::from(mesh.colors[v as usize].map(f32::from)) / 255.0);
    let mut color = Vec4::from(material.base_color) * tint;
    if let Some(texture) = material.texture.and_then(|texture| paint.textures.get(texture as usize)) {
        let uv = uv_at(mesh, point);
        color *= Vec4::from(sample(texture, material.wrap_u, material.wrap_v, uv, 0.0));
    }
    color.truncate().to_array().map(srgb_from_linear).into()
}

fn uv_at(mesh: &SkinnedMesh, point: &SurfacePoint) -> Vec2 {
    let corners = mesh.triangles[point.triangle as usize];
    (0..3).map(|c| Vec2::from(mesh.uvs[corners[c] as usize]) * point.shares[c]).sum()
}

/// Texels along u and v of a material's texture.
fn texels_of(paint: &Paint, material: u16) -> Option<Vec2> {
    let texture = paint.materials[usize::from(material)].texture?;
    let largest = paint.textures.get(texture as usize)?.mips.first()?;
    Some(Vec2::new(largest.width as f32, largest.height as f32))
}

/// The curve of sRGB, without rounding to 8 bits.
fn srgb_from_linear(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055 }
}

fn check_mesh(mesh: &SkinnedMesh, paint: &Paint, poses: &[Vec<Mat3x4>]) -> Result<()> {
    let refuse = |what, found: String, allowed: String| Err(Error::Parameter { what, found, allowed });
    let count = mesh.positions.len();
    let lengths = [
        ("normals", mesh.normals.len()),
        ("texture coordinates", mesh.uvs.len()),
        ("vertex colours", mesh.colors.len()),
        ("joints", mesh.joints.len()),
        ("weights", mesh.weights.len()),
    ];
    for (what, length) in lengths {
        if length != count {
            return refuse(what, length.to_string(), format!("{count}, one a vertex"));
        }
    }
    if mesh.triangle_materials.len() != mesh.triangles.len() {
        let allowed = format!("{}, one a triangle", mesh.triangles.len());
        return refuse("materials of triangles", mesh.triangle_materials.len().to_string(), allowed);
    }
    if let Some(v) = mesh.triangles.as_flattened().iter().find(|&&v| v as usize >= count) {
        return refuse("vertex index", v.to_string(), format!("below {count}"));
    }
    let materials = paint.materials.len();
    if let Some(m) = mesh.triangle_materials.iter().find(|&&m| usize::from(m) >= materials) {
        return refuse("material", m.to_string(), format!("below {materials}"));
    }
    let joint_count = poses.iter().map(Vec::len).min().unwrap_or(0);
    if let Some(joint) = mesh.joints.as_flattened().iter().find(|&&joint| usize::from(joint) >= joint_count) {
        return refuse("joint", joint.to_string(), format!("below {joint_count}"));
    }
    if !mesh.positions.as_flattened().iter().all(|x| x.is_finite()) {
        return refuse("position", "a number that is not finite".to_owned(), "finite numbers".to_owned());
    }
    Ok(())
}
