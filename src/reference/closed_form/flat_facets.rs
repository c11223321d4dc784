//! Any convex solid with flat facets in parallel light: slabs, prisms, cut stones.

use glam::{DVec2, DVec3};

use super::blur::{Blur, FacetEvent};
use super::convex_solid::{FacetsError, SolidFacet, facets};
use super::polygon::{area, area_in_texel, grown, intersection, shrunk};
use super::{KnownPath, TexelGrid, TexelRect};
use crate::geometry::MeshParts;
use crate::optics::{dielectric_reflectance, reflect, refract};

/// Beams followed and polygons kept at most: some gigabytes.
const MOST_BEAMS: usize = 8_000_000;

/// A convex transparent solid over the plane z = 0 in parallel light: all light on that plane.
///
/// A flat facet turns a parallel beam into parallel beams. Every sequence of facets maps the polygon in which
/// its beam falls onto the first facet to one polygon on the plane, of constant irradiance, and nothing is
/// approximated:
///
/// - the beam in the solid is cut by the outline of each facet it can reach;
/// - its irradiance across its direction, E⊥, changes at a facet (unit normal n) from direction d to d' as
///   the cross section does, and by Fresnel's F or 1 − F:  E⊥' = E⊥ |d·n| / |d'·n| · (F or 1 − F);
/// - where it leaves the solid downwards it puts E⊥ cos θ on the polygon's image on the plane, θ its angle to
///   the vertical.
///
/// The shadow in the direct light is made of the images of the lit facets along the light, which do not
/// overlap.
#[derive(Clone, Debug)]
pub struct FlatFacets {
    polygons: Vec<FloorPolygon>,
    /// Corners of each lit facet's shadow, and the distance (m) by which they may be off.
    shadow: Vec<(Vec<DVec2>, f64)>,
    floor_irradiance: f64,
    ledger: FacetLedger,
}

/// A polygon of constant irradiance on the plane z = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorPolygon {
    /// The path of its light.
    pub path: KnownPath,
    /// Corners of a convex polygon.
    pub corners: Vec<DVec2>,
    /// Irradiance E [W/m²].
    pub irradiance: f64,
    /// Distance (m) by which the corners may be off because the mesh's corners are off their facets' planes.
    pub shift: f64,
    /// Relative error of the irradiance for the same reason.
    pub relative_error: f64,
}

/// Flux that falls onto the solid, by its end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FacetLedger {
    /// Flux that falls onto the solid (W).
    pub intercepted: f64,
    /// Flux that reaches the plane (W).
    pub landed: f64,
    /// Flux that leaves upwards or level (W).
    pub escaped: f64,
    /// Flux still inside after the last reflection followed (W).
    pub cut_off: f64,
}

/// Parallel light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParallelLight {
    /// Direction of travel, a unit vector with z < 0.
    pub direction: DVec3,
    /// Irradiance across the light [W/m²].
    pub irradiance: f64,
}

/// A parallel beam inside the solid, as it leaves a facet.
struct Beam {
    facet: usize,
    /// Corners on that facet, world space.
    corners: Vec<DVec3>,
    direction: DVec3,
    /// Irradiance across the direction [W/m²].
    irradiance: f64,
    reflections: u32,
    blur: Blur,
}

impl FlatFacets {
    /// Follows all light through the solid of index `ior` (relative to its surroundings), up to
    /// `most_reflections` inside.
    ///
    /// # Errors
    ///
    /// If the solid is not convex or not above the plane, the light does not fall, or the facets make too
    /// many beams.
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

    /// The error [W/m²] of every texel's value by one path that comes from corners of the mesh off their
    /// facets' planes, in the order of [`TexelGrid::map`].
    ///
    /// It is the light of each polygon's border, as wide as its shift on either side, and the relative error
    /// of the rest.
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

    /// The flux that falls onto the solid, by its end.
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

/// Transmitted irradiance across the light over the incident, by Fresnel's formula and the change of cross
/// section.
fn transmitted(cos: f64, ior: f64) -> f64 {
    let sin_squared = (1.0 - cos * cos) / (ior * ior);
    if sin_squared >= 1.0 {
        return 0.0;
    }
    (1.0 - dielectric_reflectance(cos, ior)) * cos / (1.0 - sin_squared).sqrt()
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
mod tests;
