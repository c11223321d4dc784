//! Any convex solid with flat facets in parallel light: slabs, prisms, cut stones.

use glam::{DVec2, DVec3};

use super::blur::{Blur, FacetEvent};
use super::convex_solid::{FacetsError, SolidFacet, convex_hull, facets};
use super::polygon::{area, area_in_texel, clipped, intersection};
use super::{KnownPath, TexelGrid, TexelRect};
use crate::geometry::MeshParts;
use crate::optics::{dielectric_reflectance, reflect, refract};

/// Beams followed and polygons kept at most: some gigabytes.
const MOST_BEAMS: usize = 8_000_000;

/// A convex transparent solid over the plane z = 0 in parallel light: all light on that plane.
///
/// A flat facet turns a parallel beam into parallel beams. So every sequence of facets maps the polygon in which
/// its beam falls onto the first facet to one polygon on the plane, of constant irradiance, and nothing is
/// approximated:
///
/// - the beam in the solid is cut by the outline of each facet it can reach;
/// - its irradiance across its direction, E⊥, changes at a facet (unit normal n) from direction d to d' as the
///   cross section does, and by Fresnel's F or 1 − F:  E⊥' = E⊥ |d·n| / |d'·n| · (F or 1 − F);
/// - where it leaves the solid downwards it puts E⊥ cos θ on the polygon's image on the plane, θ its angle to the vertical.
///
/// The shadow in the direct light is made of the images of the lit facets along the light, which do not overlap.
#[derive(Clone, Debug)]
pub struct FlatFacets {
    polygons: Vec<FloorPolygon>,
    /// Of each lit facet: the corners, and how far (m) they may be off.
    shadow: Vec<(Vec<DVec2>, f64)>,
    floor_irradiance: f64,
    ledger: FacetLedger,
}

/// A polygon of constant irradiance on the plane z = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorPolygon {
    /// How its light got there.
    pub path: KnownPath,
    /// Convex.
    pub corners: Vec<DVec2>,
    /// E [W/m²].
    pub irradiance: f64,
    /// Distance (m) by which the corners may be off where the mesh's corners are off their facets' planes.
    pub shift: f64,
    /// Relative error of the irradiance for the same reason.
    pub relative_error: f64,
}

/// Where the flux that falls onto the solid goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FacetLedger {
    /// Falls onto the solid (W).
    pub intercepted: f64,
    /// Reaches the plane (W).
    pub landed: f64,
    /// Leaves upwards or level (W).
    pub escaped: f64,
    /// Was still inside after the last reflection followed (W).
    pub cut_off: f64,
}

/// Parallel light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParallelLight {
    /// Of travel, a unit vector with z < 0.
    pub direction: DVec3,
    /// Across the light [W/m²].
    pub irradiance: f64,
}

/// A parallel beam inside the solid, as it leaves a facet.
struct Beam {
    facet: usize,
    /// On that facet, world space.
    corners: Vec<DVec3>,
    direction: DVec3,
    /// Across the direction [W/m²].
    irradiance: f64,
    reflections: u32,
    blur: Blur,
}

impl FlatFacets {
    /// Follows all light through the solid of index `ior` (relative to its surroundings), up to `most_reflections`
    /// inside.
    ///
    /// # Errors
    ///
    /// If the solid is not convex or not above the plane, the light does not fall, or the facets make too many beams.
    pub fn new(
        mesh: &MeshParts,
        ior: f64,
        light: ParallelLight,
        most_reflections: u32,
    ) -> Result<Self, FacetsError> {
        let direction = light.direction.normalize_or_zero();
        if !direction.is_finite() || direction.z >= 0.0 {
            return Err(FacetsError::Direction(light.direction));
        }
        let facets = facets(mesh)?;
        let mut solved = Self {
            polygons: Vec::new(),
            shadow: Vec::new(),
            floor_irradiance: -direction.z * light.irradiance,
            ledger: FacetLedger::default(),
        };
        let mut beams = Vec::new();
        for (index, facet) in facets.iter().enumerate() {
            let cos = -direction.dot(facet.normal);
            if cos <= 0.0 {
                continue;
            }
            let corners: Vec<DVec3> = facet
                .outline
                .iter()
                .map(|&corner| facet.world(corner))
                .collect();
            let flux = light.irradiance * cos * area(&facet.outline);
            solved.ledger.intercepted += flux;
            let blur = Blur::default().landed(0.0, facet.bulge, cos);
            let shadow_blur = blur.landed(0.0, 0.0, -direction.z);
            solved
                .shadow
                .push((on_floor(&corners, direction), shadow_blur.shift));
            let reflectance = dielectric_reflectance(cos, ior);
            let reflected = reflect(direction, facet.normal);
            solved.leave(
                KnownPath::Reflected(1),
                &corners,
                reflected,
                light.irradiance * reflectance,
                flux * reflectance,
                blur.reflected(&FacetEvent {
                    cos,
                    tilt: facet.tilt,
                    part: &|cos| dielectric_reflectance(cos, ior),
                }),
            );
            if let Some(inside) = refract(direction, facet.normal, ior) {
                let cos_out = -inside.dot(facet.normal);
                let irradiance = light.irradiance * (1.0 - reflectance) * cos / cos_out;
                beams.push(Beam {
                    facet: index,
                    corners,
                    direction: inside,
                    irradiance,
                    reflections: 0,
                    blur: blur.refracted(
                        &FacetEvent {
                            cos,
                            tilt: facet.tilt,
                            part: &|cos| transmitted(cos, ior),
                        },
                        ior.recip(),
                        cos_out,
                    ),
                });
            }
        }
        while let Some(beam) = beams.pop() {
            if solved.polygons.len() + beams.len() > MOST_BEAMS {
                return Err(FacetsError::TooManyBeams { most: MOST_BEAMS });
            }
            solved.follow(&beam, &facets, ior, most_reflections, &mut beams);
        }
        Ok(solved)
    }

    /// Reports if [`Self::new`] can follow light along `direction` through the mesh.
    ///
    /// # Errors
    ///
    /// As for [`Self::new`].
    pub(super) fn check(mesh: &MeshParts, direction: DVec3) -> Result<(), FacetsError> {
        if direction.z >= 0.0 {
            return Err(FacetsError::Direction(direction));
        }
        facets(mesh).map(drop)
    }

    /// The irradiance [W/m²] averaged over a texel, by one path.
    pub fn texel_irradiance(&self, path: KnownPath, texel: &TexelRect) -> f64 {
        if path == KnownPath::Direct {
            let shaded: f64 = self
                .shadow
                .iter()
                .map(|(polygon, _)| area_in_texel(polygon, texel))
                .sum();
            return self.floor_irradiance * (1.0 - shaded / texel.area()).max(0.0);
        }
        let flux: f64 = self
            .polygons
            .iter()
            .filter(|polygon| polygon.path == path)
            .map(|polygon| polygon.irradiance * area_in_texel(&polygon.corners, texel))
            .sum();
        flux / texel.area()
    }

    /// The irradiance [W/m²] of every texel of a grid, in the order of [`TexelGrid::map`].
    pub fn map(&self, path: KnownPath, grid: &TexelGrid) -> Vec<f64> {
        let mut values = vec![0.0; grid.columns * grid.rows];
        let texel_area = grid.texel(0, 0).area();
        if path == KnownPath::Direct {
            for (polygon, _) in &self.shadow {
                spread(
                    polygon,
                    -self.floor_irradiance / texel_area,
                    grid,
                    &mut values,
                );
            }
            for value in &mut values {
                *value = (*value + self.floor_irradiance).max(0.0);
            }
        } else {
            for polygon in self.polygons.iter().filter(|polygon| polygon.path == path) {
                spread(
                    &polygon.corners,
                    polygon.irradiance / texel_area,
                    grid,
                    &mut values,
                );
            }
        }
        values
    }

    /// The irradiance [W/m²] that a texel's value by one path may be off, of all texels in the order of [`TexelGrid::map`],
    /// because corners of the mesh are off their facets' planes.
    ///
    /// It is that of a polygon's border, as wide as its shift on either side, and the relative error of the rest.
    pub(super) fn errors(&self, path: KnownPath, grid: &TexelGrid) -> Vec<f64> {
        let mut errors = vec![0.0; grid.columns * grid.rows];
        let texel_area = grid.texel(0, 0).area();
        let negligible = 1e-12 * texel_area.sqrt();
        let mut border = |corners: &[DVec2], shift: f64, irradiance: f64, relative: f64| {
            // As good as the rounding of areas.
            if shift < negligible && relative < 1e-11 {
                return;
            }
            let weight = irradiance / texel_area;
            spread(
                &grown(corners, shift),
                weight * (1.0 + relative),
                grid,
                &mut errors,
            );
            spread(&shrunk(corners, shift), -weight, grid, &mut errors);
        };
        if path == KnownPath::Direct {
            for (corners, shift) in &self.shadow {
                border(corners, *shift, self.floor_irradiance, 0.0);
            }
        } else {
            for polygon in self.polygons.iter().filter(|polygon| polygon.path == path) {
                let FloorPolygon {
                    shift,
                    irradiance,
                    relative_error,
                    ..
                } = *polygon;
                border(&polygon.corners, shift, irradiance, relative_error);
            }
        }
        for error in &mut errors {
            *error = error.max(0.0);
        }
        errors
    }

    /// All polygons that light from the solid puts on the plane.
    pub fn polygons(&self) -> &[FloorPolygon] {
        &self.polygons
    }

    /// Where the flux goes.
    pub fn ledger(&self) -> FacetLedger {
        self.ledger
    }

    /// Cuts a beam by all facets it meets; each part leaves in part and goes on in part.
    fn follow(
        &mut self,
        beam: &Beam,
        facets: &[SolidFacet],
        ior: f64,
        most_reflections: u32,
        beams: &mut Vec<Beam>,
    ) {
        for (index, facet) in facets.iter().enumerate() {
            let cos = beam.direction.dot(facet.normal);
            if index == beam.facet || cos <= 0.0 {
                continue;
            }
            let mut farthest = 0.0_f64;
            let landed: Vec<DVec2> = beam
                .corners
                .iter()
                .map(|&corner| {
                    let distance = (facet.origin - corner).dot(facet.normal) / cos;
                    farthest = farthest.max(distance);
                    facet.local(corner + beam.direction * distance)
                })
                .collect();
            let part = intersection(&landed, &facet.outline);
            let part_area = area(&part).abs();
            if part_area == 0.0 {
                continue;
            }
            let corners: Vec<DVec3> = part.iter().map(|&corner| facet.world(corner)).collect();
            let flux = beam.irradiance * cos * part_area;
            let mut reflectance = 1.0;
            let blur = beam.blur.landed(farthest, facet.bulge, cos);
            let let_out = |cos: f64| transmitted(cos, ior.recip());
            let kept_inside = |cos: f64| dielectric_reflectance(cos, ior.recip());
            let tilt = facet.tilt;
            if let Some(outside) = refract(beam.direction, -facet.normal, ior.recip()) {
                reflectance = dielectric_reflectance(cos, ior.recip());
                let cos_out = outside.dot(facet.normal);
                let irradiance = beam.irradiance * (1.0 - reflectance) * cos / cos_out;
                let path = KnownPath::Through(beam.reflections);
                self.leave(
                    path,
                    &corners,
                    outside,
                    irradiance,
                    flux * (1.0 - reflectance),
                    blur.refracted(
                        &FacetEvent {
                            cos,
                            tilt,
                            part: &let_out,
                        },
                        ior,
                        cos_out,
                    ),
                );
            }
            if beam.reflections == most_reflections {
                self.ledger.cut_off += flux * reflectance;
            } else {
                beams.push(Beam {
                    facet: index,
                    corners,
                    direction: reflect(beam.direction, facet.normal),
                    irradiance: beam.irradiance * reflectance,
                    reflections: beam.reflections + 1,
                    blur: blur.reflected(&FacetEvent {
                        cos,
                        tilt,
                        part: &kept_inside,
                    }),
                });
            }
        }
    }

    /// Light that has left the solid: to the plane or away.
    fn leave(
        &mut self,
        path: KnownPath,
        corners: &[DVec3],
        direction: DVec3,
        irradiance: f64,
        flux: f64,
        blur: Blur,
    ) {
        // Flatter than this the image would be a million times as long as the solid is high.
        if direction.z < -1e-6 {
            self.ledger.landed += flux;
            let farthest = corners
                .iter()
                .map(|corner| corner.z / -direction.z)
                .fold(0.0, f64::max);
            let blur = blur.landed(farthest, 0.0, -direction.z);
            self.polygons.push(FloorPolygon {
                path,
                corners: on_floor(corners, direction),
                irradiance: irradiance * -direction.z,
                shift: blur.shift,
                relative_error: blur.relative,
            });
        } else {
            self.ledger.escaped += flux;
        }
    }
}

/// Transmitted irradiance across the light over the incident, by Fresnel's formula and the change of cross section.
fn transmitted(cos: f64, ior: f64) -> f64 {
    let sin_squared = (1.0 - cos * cos) / (ior * ior);
    if sin_squared >= 1.0 {
        return 0.0;
    }
    (1.0 - dielectric_reflectance(cos, ior)) * cos / (1.0 - sin_squared).sqrt()
}

/// A convex polygon that holds all points within `by` of a convex polygon.
fn grown(polygon: &[DVec2], by: f64) -> Vec<DVec2> {
    let offsets = [(-by, -by), (by, -by), (by, by), (-by, by)];
    convex_hull(
        polygon
            .iter()
            .flat_map(|corner| offsets.map(|(x, y)| *corner + DVec2::new(x, y)))
            .collect(),
    )
}

/// The part of a convex polygon whose points are all `by` and more from its border.
fn shrunk(polygon: &[DVec2], by: f64) -> Vec<DVec2> {
    let turn = if area(polygon) < 0.0 { -1.0 } else { 1.0 };
    let mut kept = polygon.to_vec();
    for (i, &from) in polygon.iter().enumerate() {
        let side = polygon[(i + 1) % polygon.len()] - from;
        let length = side.length();
        if length > 0.0 {
            kept = clipped(&kept, |point| {
                turn * side.perp_dot(point - from) / length - by
            });
        }
    }
    kept
}

/// The image on z = 0 along `direction`.
fn on_floor(corners: &[DVec3], direction: DVec3) -> Vec<DVec2> {
    corners
        .iter()
        .map(|&corner| (corner - direction * (corner.z / direction.z)).truncate())
        .collect()
}

/// Adds `weight` times the polygon's area in each texel.
fn spread(polygon: &[DVec2], weight: f64, grid: &TexelGrid, values: &mut [f64]) {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for &corner in polygon {
        low = low.min(corner);
        high = high.max(corner);
    }
    let scale =
        DVec2::new(grid.columns as f64, grid.rows as f64) / (grid.bounds.max - grid.bounds.min);
    let index = |position: DVec2| ((position - grid.bounds.min) * scale).floor();
    let last = DVec2::new(grid.columns as f64 - 1.0, grid.rows as f64 - 1.0);
    // A texel more on every side: the division above is rounded.
    let first = (index(low) - 1.0).max(DVec2::ZERO);
    let end = (index(high) + 1.0).min(last);
    if first.x > end.x || first.y > end.y {
        return;
    }
    for row in first.y as usize..=end.y as usize {
        for column in first.x as usize..=end.x as usize {
            values[row * grid.columns + column] +=
                weight * area_in_texel(polygon, &grid.texel(column, row));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{BrilliantCut, equilateral_prism, round_brilliant};

    fn light(x: f64, y: f64) -> ParallelLight {
        ParallelLight {
            direction: DVec3::new(x, y, -1.0).normalize(),
            irradiance: 1000.0,
        }
    }

    /// A block from `min` to `max`.
    fn block(min: DVec3, max: DVec3) -> MeshParts {
        let corner = |i: u32| {
            DVec3::from_array(std::array::from_fn(|axis| {
                if i >> axis & 1 == 0 {
                    min[axis]
                } else {
                    max[axis]
                }
            }))
        };
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        MeshParts {
            positions: (0..8).map(corner).collect(),
            triangles: quads
                .iter()
                .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
                .collect(),
            ..MeshParts::default()
        }
    }

    fn stone() -> MeshParts {
        let mut mesh = round_brilliant(1.0, BrilliantCut::TOLKOWSKY);
        let (sin, cos) = 0.3_f64.sin_cos();
        for position in &mut mesh.positions {
            *position = DVec3::new(
                cos * position.x + sin * position.z,
                position.y,
                cos * position.z - sin * position.x + 2.0,
            );
        }
        mesh
    }

    #[test]
    fn a_blocks_six_facets_are_found_in_its_twelve_triangles() {
        assert_eq!(
            facets(&block(DVec3::new(0.0, 0.0, 1.0), DVec3::ONE * 2.0))
                .unwrap()
                .len(),
            6
        );
        assert_eq!(facets(&stone()).unwrap().len(), 57 + 16);
    }

    #[test]
    fn the_ledger_closes() {
        for (mesh, ior, reflections) in [
            (
                block(DVec3::new(-1.0, -1.0, 0.5), DVec3::new(1.0, 1.0, 2.0)),
                1.5,
                12,
            ),
            (stone(), 2.418, 5),
        ] {
            let ledger = FlatFacets::new(&mesh, ior, light(0.3, 0.1), reflections)
                .unwrap()
                .ledger();
            let sum = ledger.landed + ledger.escaped + ledger.cut_off;
            // Beams are cut at shared edges: rounding of 1e-15 of the solid's size each, thousands of them.
            assert!((sum / ledger.intercepted - 1.0).abs() < 1e-11, "{ledger:?}");
            assert!(ledger.landed > 0.05 * ledger.intercepted && ledger.escaped > 0.0);
        }
    }

    #[test]
    fn a_wide_slab_transmits_and_shifts_as_the_formula_says() {
        use super::super::FlatSlab;
        let mesh = block(DVec3::new(-50.0, -50.0, 1.0), DVec3::new(50.0, 50.0, 1.5));
        let solved = FlatFacets::new(&mesh, 1.5, light(0.75, 0.0), 4).unwrap();
        let slab = FlatSlab {
            thickness: 0.5,
            ior: 1.5,
        };
        let cos = 0.8;
        let texel = TexelRect::new(-0.1, -0.1, 0.1, 0.1);
        for k in 0..4 {
            let exact = 1000.0 * cos * slab.transmitted_fraction(cos, KnownPath::Through(k));
            let irradiance = solved.texel_irradiance(KnownPath::Through(k), &texel);
            assert!(
                (irradiance - exact).abs() < 1e-10 * 1000.0,
                "{k}: {irradiance} {exact}"
            );
        }
        assert_eq!(solved.texel_irradiance(KnownPath::Direct, &texel), 0.0);
        // The image's left border is that of the top facet, moved by the light and back by the slab.
        let edge = -50.0 + 0.75 * 1.5 - slab.foot_shift(0.75_f64.atan(), 0);
        let image = solved
            .polygons()
            .iter()
            .filter(|polygon| polygon.path == KnownPath::Through(0));
        let left = image
            .flat_map(|polygon| &polygon.corners)
            .map(|corner| corner.x)
            .fold(f64::INFINITY, f64::min);
        assert!((left - edge).abs() < 1e-12, "{left} {edge}");
    }

    #[test]
    fn a_prism_at_minimum_deviation_turns_light_by_its_formula() {
        let mut mesh = equilateral_prism(0.1, 0.2);
        // As in the bundled scene: length along y, upper face at the incidence asin(3/4).
        let (sin, cos) = (0.75_f64.asin() - std::f64::consts::FRAC_PI_6).sin_cos();
        for position in &mut mesh.positions {
            let (x, y, z) = (position.x, -position.z, position.y);
            *position = DVec3::new(cos * x + sin * z, y, cos * z - sin * x + 0.15);
        }
        let solved = FlatFacets::new(&mesh, 1.5, light(0.0, 0.0), 0).unwrap();
        let deviation = 2.0 * 0.75_f64.asin() - std::f64::consts::FRAC_PI_3;
        // In at cos i, out at cos i: the beam keeps its width, and falls on the floor at the deviation.
        let reflectance = dielectric_reflectance((7.0_f64 / 16.0).sqrt(), 1.5);
        let exact = 1000.0 * (1.0 - reflectance).powi(2) * deviation.cos();
        let found = solved
            .polygons()
            .iter()
            .filter(|polygon| polygon.path == KnownPath::Through(0));
        let nearest = found
            .map(|polygon| (polygon.irradiance - exact).abs())
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-10 * exact, "{nearest}");
    }

    #[test]
    fn a_map_is_its_texels_and_its_sum_is_what_landed() {
        let mesh = block(DVec3::new(-0.5, -0.5, 0.25), DVec3::new(0.5, 0.5, 1.25));
        let solved = FlatFacets::new(&mesh, 1.5, light(0.5, 0.2), 3).unwrap();
        let grid = TexelGrid::square(8.0, 40);
        let mut landed = 0.0;
        for path in [
            KnownPath::Reflected(1),
            KnownPath::Through(0),
            KnownPath::Through(1),
            KnownPath::Through(2),
            KnownPath::Through(3),
        ] {
            let map = solved.map(path, &grid);
            let (column, row) = (21, 20);
            let texel = solved.texel_irradiance(path, &grid.texel(column, row));
            assert!((map[row * 40 + column] - texel).abs() < 1e-12 * 1000.0);
            landed += map.iter().sum::<f64>() * grid.texel(0, 0).area();
        }
        assert!((landed / solved.ledger().landed - 1.0).abs() < 1e-12);
        let shaded = 1600.0
            - solved.map(KnownPath::Direct, &grid).iter().sum::<f64>() / solved.floor_irradiance;
        let shadow =
            solved.ledger().intercepted / solved.floor_irradiance / grid.texel(0, 0).area();
        assert!((shaded - shadow).abs() < 1e-10);
    }

    #[test]
    fn solids_that_are_not_convex_or_too_low_and_light_from_below_are_refused() {
        let mut dented = block(DVec3::new(-0.5, -0.5, 0.25), DVec3::new(0.5, 0.5, 1.25));
        dented.positions[7] = DVec3::new(0.1, 0.1, 0.9);
        assert!(matches!(
            FlatFacets::new(&dented, 1.5, light(0.0, 0.0), 1),
            Err(FacetsError::NotConvex { .. })
        ));
        let low = block(DVec3::new(-0.5, -0.5, -0.25), DVec3::new(0.5, 0.5, 1.25));
        assert!(matches!(
            FlatFacets::new(&low, 1.5, light(0.0, 0.0), 1),
            Err(FacetsError::BelowThePlane { .. })
        ));
        let good = block(DVec3::new(-0.5, -0.5, 0.25), DVec3::new(0.5, 0.5, 1.25));
        let mut torn = good.clone();
        torn.triangles[3][1] = 8;
        assert!(matches!(
            FlatFacets::new(&torn, 1.5, light(0.0, 0.0), 1),
            Err(FacetsError::Vertex {
                triangle: 3,
                vertex: 8
            })
        ));
        let upward = ParallelLight {
            direction: DVec3::Z,
            irradiance: 1.0,
        };
        assert!(matches!(
            FlatFacets::new(&good, 1.5, upward, 1),
            Err(FacetsError::Direction(_))
        ));
    }
}
