// Light from outside the scene: its radiance in a direction, how directions are sampled, and with which density. docs/conventions.md, "Environment".
#include "../mutants.h"

layout(constant_id = kConstantEnvironment) const uint kEnvironment = kEnvironmentNone;
layout(constant_id = kConstantEnvironmentAlone) const bool kEnvironmentAlone = false;  // there is no other light
layout(constant_id = kConstantEnvironmentColumns) const uint kEnvironmentColumns = 1u;
layout(constant_id = kConstantEnvironmentTexelRows) const uint kEnvironmentTexelRows = 1u;
layout(constant_id = kConstantEnvironmentCellRows) const uint kEnvironmentCellRows = 1u;
layout(constant_id = kConstantEnvironmentRowLevels) const uint kEnvironmentRowLevels = 0u;
layout(constant_id = kConstantEnvironmentColumnLevels) const uint kEnvironmentColumnLevels = 0u;
const bool kHasEnvironment = kEnvironment != kEnvironmentNone;
const bool kHasOutside = kHasEnvironment || kDistantLights > 0u;
#ifdef ETENDUE_PLAIN
const bool kEnvironmentPictured = false;
#else
const bool kEnvironmentPictured = kEnvironment == kEnvironmentPicture;
#endif

// More cells than texels in a column: rows are bands, and the first and last row of cells are half a band each.
const bool kEnvironmentBands = kEnvironmentCellRows > kEnvironmentTexelRows;
// Row coordinate of cells: its value at the north pole, and the increase from there to the south pole.
float environment_first_row() { return kEnvironmentBands ? 0.5 : 0.0; }
float environment_row_range() { return float(kEnvironmentBands ? kEnvironmentTexelRows : kEnvironmentTexelRows - 1u); }
const uint kGradientRows = 32u;  // above the horizon

// The angle of (x, y) from the x axis as eighths · π/4 + rest, eighths in 0…8 and |rest| <= π/8, because a single float
// would not be precise enough for the columns of a large picture. Polynomial of [Moshier1989].
void split_angle(float y, float x, out float eighths, out float rest) {
  const float large = max(abs(x), abs(y));
  const float t = min(abs(x), abs(y)) / max(large, 1e-37);
  const bool steep = t > 0.414213562;
  const float s = steep ? (t - 1.0) / (t + 1.0) : t;
  const float s2 = s * s;
  rest = s + s * s2 * (-3.33329491539e-1 + s2 * (1.99777106478e-1 + s2 * (-1.38776856032e-1 + s2 * 8.05374449538e-2)));
  eighths = steep ? 1.0 : 0.0;
  const bool across = abs(y) > abs(x);
  eighths = across ? 2.0 - eighths : eighths;
  rest = across ? -rest : rest;
  eighths = x < 0.0 ? 4.0 - eighths : eighths;
  rest = x < 0.0 ? -rest : rest;
  eighths = y < 0.0 ? 8.0 - eighths : eighths;
  rest = y < 0.0 ? -rest : rest;
}

// floor(whole + rest) and the remainder, where `whole` is exact.
float split_coordinate(float whole, float rest, out float fraction) {
  const float base = floor(whole);
  const float above = (whole - base) + rest;
  fraction = above - floor(above);
  return base + floor(above);
}

// Row of cells at the angle θ from the north pole; `fraction` is the position down the cell.
uint environment_row(float sin_theta, float cos_theta, out float fraction) {
  float eighths, rest;
  split_angle(sin_theta, cos_theta, eighths, rest);
  const float range = environment_row_range();
  const float row = split_coordinate(range * eighths * 0.25 + environment_first_row(), range * rest * kInvPi, fraction);
  const float last = float(kEnvironmentCellRows - 1u);
  fraction = row < 0.0 ? 0.0 : row > last ? 1.0 : fraction;
  return uint(clamp(row, 0.0, last));
}

// The cell of a direction in the sky's frame.
EnvironmentPlace environment_place(vec3 d) {
  EnvironmentPlace at;
  if (!kEnvironmentPictured) {
    at.row = d.y < 0.0 ? kGradientRows : min(uint((1.0 - d.y) * float(kGradientRows)), kGradientRows - 1u);
    at.column = 0u;
    return at;
  }
  float eighths, rest;
  split_angle(d.x, -d.z, eighths, rest);
  float whole = float(kEnvironmentColumns) * eighths * 0.125 - 0.5;
  MUTATE(kMutantEnvironmentShifted, whole += 0.5);
  const float column = split_coordinate(whole, float(kEnvironmentColumns) * rest * (0.5 * kInvPi), at.across);
  const float wrapped = column < 0.0 ? column + float(kEnvironmentColumns) : column;
  at.column = uint(wrapped >= float(kEnvironmentColumns) ? wrapped - float(kEnvironmentColumns) : wrapped);
  at.row = environment_row(sqrt(d.x * d.x + d.z * d.z), d.y, at.down);
  return at;
}

vec3 environment_texel(int row, uint column) {
  uint y = uint(clamp(row, 0, int(kEnvironmentTexelRows) - 1));
  MUTATE(kMutantEnvironmentUpsideDown, y = kEnvironmentTexelRows - 1u - y);
  return fetch_environment_texel(y * kEnvironmentColumns + column).radiance;
}

// The picture, bilinear between the corners of a cell.
vec3 picture_radiance(EnvironmentPlace at) {
  const int upper = int(at.row) - (kEnvironmentBands ? 1 : 0);
  const uint next = at.column + 1u == kEnvironmentColumns ? 0u : at.column + 1u;
  const vec3 above = mix(environment_texel(upper, at.column), environment_texel(upper, next), at.across);
  const vec3 below = mix(environment_texel(upper + 1, at.column), environment_texel(upper + 1, next), at.across);
  return mix(above, below, at.down);
}

vec3 gradient_radiance(vec3 d) {
  MUTATE(kMutantSkyMirrored, d.y = -d.y);
  return mix(frame.sky_horizon, frame.sky_top, clamp(d.y, 0.0, 1.0));
}

// Probability of a cell within its row.
float cell_prob(EnvironmentRow row, uint r, uint column) {
  if (!kEnvironmentPictured) return 1.0;
  if (column >= row.column_count) return 0.0;
  const uint words = fetch_environment_texel(r * kEnvironmentColumns + column).words;
  return words == 0u ? (column + 1u == row.column_count ? 1.0 : 0.0) : float(words) * (1.0 / 4294967296.0);
}

// Density of sampling some direction of the cell, w.r.t. solid angle and with the choice of the environment.
float environment_cell_pdf(EnvironmentRow row, uint r, uint column) {
  float pdf_w = row.density * cell_prob(row, r, column);
  MUTATE(kMutantEnvironmentSineForgotten, pdf_w *= abs(row.lower_edge - row.upper_edge) * float(kEnvironmentCellRows));
  MUTATE(kMutantEnvironmentChoiceForgotten, pdf_w /= 1.0 - frame.lights_prob);
  return pdf_w;
}

// Number of nodes in a level, each of which covers `span` entries, and in all levels.
uint search_nodes(uint count, uint span) { return (count + span - 1u) / span; }
uint search_size(uint count, uint levels) {
  uint size = 0u, span = kSearchFan;
  for (uint i = 0u; i < levels; ++i) {
    size += search_nodes(count, span);
    span *= kSearchFan;
  }
  return size;
}

// Last of `count` entries whose threshold is <= word: integers, so every device makes the same choice. `count` and
// `levels` are constants, so that loops are unrolled; `first` is the root.
uint search_entry(uint first, uint count, uint levels, uint word) {
  uint span = 1u;
  for (uint i = 0u; i < levels; ++i) span *= kSearchFan;
  uint found = 0u;
  for (uint i = 0u; i < levels; ++i) {
    const uvec4 node = fetch_environment_search(first + found);
    first += search_nodes(count, span);
    span /= kSearchFan;
    found = kSearchFan * found + uint(node.x <= word) + uint(node.y <= word) + uint(node.z <= word) + uint(node.w <= word);
    found = min(found, (count - 1u) / span);  // the largest word also passes the thresholds beyond the last entry
  }
  return found;
}

uint choose_environment_row(uint word) {
  return min(search_entry(0u, kEnvironmentCellRows, kEnvironmentRowLevels, word), frame.environment_row_count - 1u);
}

uint choose_environment_column(uint row, uint column_count, uint word) {
  if (!kEnvironmentPictured) return 0u;
  const uint first = search_size(kEnvironmentCellRows, kEnvironmentRowLevels) + row * search_size(kEnvironmentColumns, kEnvironmentColumnLevels);
  return min(search_entry(first, kEnvironmentColumns, kEnvironmentColumnLevels, word), column_count - 1u);
}

vec3 world_from_sky(vec3 d) { return frame.sky_x * d.x + frame.sky_y * d.y + frame.sky_z * d.z; }
vec3 sky_from_world(vec3 w) {
  MUTATE(kMutantSkyTurnedBack, return world_from_sky(w));
  return vec3(dot(frame.sky_x, w), dot(frame.sky_y, w), dot(frame.sky_z, w));
}

// The radiance from direction w of the world, for a sky picture still to be multiplied by the picture at `at`; `pdf_w` is the density with which
// sample_environment finds the direction.
vec3 environment_radiance(vec3 w, out EnvironmentPlace at, out float pdf_w) {
  const vec3 d = sky_from_world(w);
  at = environment_place(d);
  pdf_w = environment_cell_pdf(fetch_environment_row(at.row), at.row, at.column);
  return kEnvironmentPictured ? vec3(1.0) : gradient_radiance(d);
}

// Whether the words choose the environment rather than a light.
bool chooses_environment(uvec4 words) { return kHasEnvironment && (kEnvironmentAlone || words.x < frame.environment_threshold); }

// Whether they choose a directional light, if they do not choose the environment.
#define chooses_distant_light(words) (kDistantLights > 0u && (frame.light_instance_count == 0u || (words).x < frame.distant_threshold))

// A direction, as a light at infinity; as above, the picture is not looked up yet.
LightSample sample_environment(uvec4 words) {
  EnvironmentPlace at;
  at.row = choose_environment_row(words.x);
  const EnvironmentRow row = fetch_environment_row(at.row);
  at.column = choose_environment_column(at.row, row.column_count, words.y);
  at.across = to_unit(words.z);
  // sin² of half the angle from the nearer pole, uniform in the cosine.
  const float s = row.upper_edge + to_unit(words.w) * (row.lower_edge - row.upper_edge);
  const float side = 2u * at.row < kEnvironmentCellRows ? 1.0 : -1.0;
  const float sin_theta = 2.0 * sqrt(max(0.0, s * (1.0 - s)));
  const float cos_theta = side * (1.0 - 2.0 * s);
  const float u = (float(at.column) + 0.5 + at.across) / float(kEnvironmentColumns);
  const vec2 turn = cos_sin_turn(u >= 1.0 ? u - 1.0 : u);
  const vec3 d = vec3(sin_theta * turn.y, cos_theta, -sin_theta * turn.x);
  LightSample ls;
  ls.wi = world_from_sky(d);
  ls.pdf_w = environment_cell_pdf(row, at.row, at.column);
  ls.mis_pdf = ls.pdf_w;
  if (kEnvironmentPictured) {
    // At a cell's edge, rounding may lead to the neighbouring cell.
    const uint found = environment_row(sin_theta, cos_theta, at.down);
    at.down = found == at.row ? at.down : found > at.row ? 1.0 : 0.0;
  }
  ls.sky = at;
  ls.radiance = kEnvironmentPictured ? vec3(1.0) : gradient_radiance(d);
  ls.instance = kEnvironmentLight;
  ls.primitive = at.row * kEnvironmentColumns + at.column;
  return ls;
}
