// The ring grid around the camera ([Yusov14] 5.2, after Losasso and Hoppe's geometry clipmaps, 2004): square rings of
// cells that double in size from ring to ring, with overlaps where neighbouring rings fade into each other.
#ifndef NEPHELE_SHARED_RING_GRID_H
#define NEPHELE_SHARED_RING_GRID_H

#include "field_constants.h"
#include "world.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kNoCell, 0xffffffffu);
NEPHELE_CONST(float, kViewFade, 0.2f);  // the last part of the view distance, where clouds fade

NEPHELE_FN float saturate(float x) { return clamp(x, 0.0f, 1.0f); }

// A cell of the ring grid. Cells of all rings are numbered ring by ring, row by row.
struct GridCell {
  uint ring;
  ivec2 index;    // lattice cell of the ring, counted from the grid origin
  vec2 corner_m;  // grid space
  float size_m;
};

NEPHELE_FN uint ring_lattice(CloudField field, uint ring) {
  return uint(kOriginUnitM / field.inner_cell_m + 0.5f) >> ring;
}
NEPHELE_FN float ring_cell_m(CloudField field, uint ring) { return lattice_cell_m(ring_lattice(field, ring)); }

NEPHELE_FN uint last_ring(CloudField field) { return field.first_ring + field.ring_count - 1u; }

NEPHELE_FN uint grid_cell_count(CloudField field) {
  return field.ring_count * field.ring_size_cells * field.ring_size_cells;
}

// The ring's lower corner: the camera is within one cell of the ring's centre, and the ring's border falls on cell
// borders of the next ring, so that finer rings exactly fill whole coarser cells.
NEPHELE_FN ivec2 ring_corner(CloudField field, uint ring) {
  ivec2 pair = (field.camera_cell + ivec2(1 << int(ring))) >> (int(ring) + 1);  // the corner of four that is nearest
  return pair * 2 - ivec2(int(field.ring_size_cells) / 2);
}

NEPHELE_FN GridCell grid_cell(CloudField field, uint cell) {
  uint side = field.ring_size_cells;
  GridCell result;
  uint rings_before = cell / (side * side);
  result.ring = field.first_ring + rings_before;
  uint in_ring = cell - rings_before * side * side;
  uint row = in_ring / side;
  result.index = ring_corner(field, result.ring) + ivec2(int(in_ring - row * side), int(row));
  result.size_m = ring_cell_m(field, result.ring);
  result.corner_m = vec2(float(result.index.x), float(result.index.y)) * result.size_m;
  return result;
}

// The cell of a ring that holds a place; kNoCell outside the ring.
NEPHELE_FN uint grid_cell_at(CloudField field, uint ring, vec2 p_grid_m) {
  ivec2 at = ivec2(floor(lattice_position(p_grid_m, ring_lattice(field, ring)))) - ring_corner(field, ring);
  int side = int(field.ring_size_cells);
  if (at.x < 0 || at.y < 0 || at.x >= side || at.y >= side) return kNoCell;
  return ((ring - field.first_ring) * field.ring_size_cells + uint(at.y)) * field.ring_size_cells + uint(at.x);
}

// Distance at which a ring has faded out: every nearer cell centre lies inside it wherever the camera is in its cell.
NEPHELE_FN float ring_reach_m(CloudField field, uint ring) {
  return (0.5f * float(field.ring_size_cells) - 0.5f) * ring_cell_m(field, ring);
}

// 1 where a ring or a finer one shows, falling to 0 over its outermost eighth.
NEPHELE_FN float ring_presence(CloudField field, uint ring, float distance_m) {
  float overlap = 0.0625f * float(field.ring_size_cells) * ring_cell_m(field, ring);
  return saturate((ring_reach_m(field, ring) - distance_m) / overlap);
}

// How far clouds are drawn: the view distance, or the last ring's reach.
NEPHELE_FN float cloud_reach_m(CloudField field) {
  return min(field.view_distance_m, ring_reach_m(field, last_ring(field)));
}

// Share of a ring in the optical depth at a horizontal distance. Over all rings the shares sum to 1, and to the fade
// towards the end of the view distance beyond.
NEPHELE_FN float lod_weight(CloudField field, uint ring, float distance_m) {
  float reach = max(cloud_reach_m(field), 1e-3f);
  float fade = saturate((reach - distance_m) / (kViewFade * reach));
  float inner = ring > field.first_ring ? ring_presence(field, ring - 1u, distance_m) : 0.0f;
  float outer = ring < last_ring(field) ? ring_presence(field, ring, distance_m) : 1.0f;
  return fade * (outer - inner);
}

// Of the cell's centre, horizontally.
NEPHELE_FN float cell_distance_m(FieldFrame frame, GridCell cell) {
  float dx = cell.corner_m.x + 0.5f * cell.size_m - frame.camera_grid_m.x;
  float dy = cell.corner_m.y + 0.5f * cell.size_m - frame.camera_grid_m.y;
  return sqrt(dx * dx + dy * dy);
}

NEPHELE_FN float cell_weight(FieldFrame frame, GridCell cell) {
  return lod_weight(frame.field, cell.ring, cell_distance_m(frame, cell));
}

// Whether a cell may show while the camera stays in its finest cell: what is found there lasts as long.
NEPHELE_FN bool cell_may_show(CloudField field, GridCell cell) {
  float finest_m = ring_cell_m(field, 0u);
  float dx = cell.corner_m.x + 0.5f * cell.size_m - (float(field.camera_cell.x) + 0.5f) * finest_m;
  float dy = cell.corner_m.y + 0.5f * cell.size_m - (float(field.camera_cell.y) + 0.5f) * finest_m;
  float distance_m = sqrt(dx * dx + dy * dy);
  float way_m = 0.75f * finest_m;  // half the finest cell's diagonal, and rounding
  if (distance_m - way_m >= cloud_reach_m(field)) return false;
  if (cell.ring < last_ring(field) && ring_presence(field, cell.ring, distance_m - way_m) <= 0.0f) return false;
  return cell.ring == field.first_ring || ring_presence(field, cell.ring - 1u, distance_m + way_m) < 1.0f;
}

// Cells sorted by distance, coarsely: what finds no room in a buffer is left out from the last bin on.
NEPHELE_CONST(uint, kDistanceBins, 256u);

NEPHELE_FN uint distance_bin(FieldFrame frame, GridCell cell) {
  float share = cell_distance_m(frame, cell) / max(cloud_reach_m(frame.field), 1e-3f);
  return min(uint(float(kDistanceBins) * share), kDistanceBins - 1u);
}

#ifdef __cplusplus
// Puts the camera into the grid. On the CPU, so that all passes agree on the cell; inner_cell_m must be set.
inline void place_camera(FieldFrame& frame, const GridPlace& place) {
  frame.field.origin_index = place.origin_index;
  frame.camera_grid_m = place.grid_m;
  frame.field.camera_cell =
      ivec2(floor(lattice_position(vec2(place.grid_m.x, place.grid_m.y), ring_lattice(frame.field, 0u))));
}
#endif

NEPHELE_SHARED_END

#endif
