#include "sculpt/robot.h"

#include <algorithm>

#include "core/errors.h"
#include "image/image.h"
#include "sculpt/pictures.h"

namespace etendue::sculpt {
namespace {

constexpr int kArc = 6;  // segments of a rounded edge

/// Unless two of its corners are in the same place, as in a quad at a pole.
void add_triangle(Mesh& mesh, const std::array<std::uint32_t, 3>& t) {
  const auto& p = mesh.positions;
  if (!(length(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]])) > 0.0)) return;
  if (faces_away(mesh, t)) throw Error(ErrorKind::comparison, "a triangle of the robot faces away from its normals");
  mesh.triangles.push_back(t);
}

/// Quads between `columns` and `rows` of vertices that were just added, row by row.
void add_quads(Mesh& mesh, std::uint32_t first, std::uint32_t rows, std::uint32_t columns) {
  for (std::uint32_t j = 0; j + 1 < rows; ++j) {
    for (std::uint32_t i = 0; i + 1 < columns; ++i) {
      const std::uint32_t a = first + j * columns + i, b = a + columns;
      add_triangle(mesh, {a, a + 1, b + 1});
      add_triangle(mesh, {a, b + 1, b});
    }
  }
}

/// Coordinates along one side of a face: `half` from the middle to the edge, the last `edge` of it rounded.
std::vector<double> ticks(double half, double edge) {
  std::vector<double> out;
  for (int i = -kArc; i <= kArc; ++i) {
    const double turn = std::abs(i) / (8.0 * kArc), tangent = sin_turns(turn) / cos_turns(turn);
    const double out_of_middle = i == 0 ? 0.0 : half - edge + edge * tangent;
    out.push_back(i < 0 ? -out_of_middle : out_of_middle);
  }
  return out;
}

/// A box with rounded edges around the origin. Each face has (u, v) from 0 to 1.
Mesh box(Vec3 half, double edge) {
  Mesh mesh;
  const double sizes[3] = {half.x, half.y, half.z};
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, across = (axis + (face % 2 == 0 ? 1 : 2)) % 3, up = 3 - axis - across;
    const std::vector<double> u = ticks(sizes[across], edge), v = ticks(sizes[up], edge);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const double y : v) {
      for (const double x : u) {
        double p[3], inner[3];
        p[axis] = face % 2 == 0 ? sizes[axis] : -sizes[axis], p[across] = x, p[up] = y;
        for (int k = 0; k < 3; ++k) inner[k] = std::clamp(p[k], edge - sizes[k], sizes[k] - edge);
        const Vec3 middle{inner[0], inner[1], inner[2]}, normal = normalize(Vec3{p[0], p[1], p[2]} - middle);
        mesh.normals.push_back(normal);
        mesh.positions.push_back(middle + edge * normal);
        mesh.uvs.push_back({0.5 + 0.5 * x / sizes[across], 0.5 + 0.5 * y / sizes[up]});
      }
    }
    add_quads(mesh, first, static_cast<std::uint32_t>(v.size()), static_cast<std::uint32_t>(u.size()));
  }
  return mesh;
}

/// A point of an outline that is turned about the y axis, from below to above, and its normal.
struct Turned {
  double radius, height, out, up;
};

Mesh turn(const std::vector<Turned>& outline) {
  constexpr std::uint32_t kAround = 48;
  Mesh mesh;
  for (const Turned& p : outline) {
    for (std::uint32_t i = 0; i <= kAround; ++i) {
      const double u = static_cast<double>(i % kAround) / kAround, c = cos_turns(u), s = -sin_turns(u);
      mesh.positions.push_back({p.radius * c, p.height, p.radius * s});
      mesh.normals.push_back(normalize(Vec3{p.out * c, p.up, p.out * s}));
      mesh.uvs.push_back({static_cast<double>(i) / kAround, 0.5 + p.height});
    }
  }
  add_quads(mesh, 0, static_cast<std::uint32_t>(outline.size()), kAround + 1);
  return mesh;
}

/// A cylinder around the y axis with rounded rims; a ball if all three lengths are the same.
Mesh drum(double radius, double half, double edge) {
  std::vector<Turned> outline;
  if (edge < radius) outline.push_back({0.0, -half, 0.0, -1.0});
  for (const double side : {-1.0, 1.0}) {
    for (int i = 0; i <= 2 * kArc; ++i) {
      const double turn = 0.25 * (side < 0.0 ? i / (2.0 * kArc) - 1.0 : i / (2.0 * kArc));
      const double c = cos_turns(turn), s = sin_turns(turn);
      outline.push_back({radius - edge + edge * c, side * (half - edge) + edge * s, c, s});
    }
  }
  if (edge < radius) outline.push_back({0.0, half, 0.0, 1.0});
  return turn(outline);
}

Mesh ring(double radius, double wire) {
  std::vector<Turned> outline;
  for (int i = 0; i <= 4 * kArc; ++i) {
    const double turn = i / (4.0 * kArc), c = cos_turns(turn), s = sin_turns(turn);
    outline.push_back({radius + wire * c, wire * s, c, s});
  }
  return turn(outline);
}

Json numbers(Vec3 v) {
  return Json{v.x, v.y, v.z};
}

/// A rotation about an axis by so many turns.
Json rotation(Vec3 axis, double turns) {
  const Vec3 v = sin_turns(0.5 * turns) * axis;
  return Json{v.x, v.y, v.z, cos_turns(0.5 * turns)};
}

/// Puts parts together.
class Toy {
 public:
  Toy() {
    red_ = lacquer({0.60, 0.025, 0.02});
    blue_ = lacquer({0.03, 0.22, 0.36});
    cream_ = lacquer({0.78, 0.66, 0.42});
    steel_ = metal({0.62, 0.62, 0.64}, 0.28);
    brass_ = metal({0.86, 0.62, 0.26}, 0.25);
    dark_ = metal({0.10, 0.10, 0.11}, 0.45);
  }

  Glb build() {
    body();
    head();
    arm(-1.0, 0.055), arm(1.0, 0.36);
    surroundings();
    view();
    glb_["asset"] = Json{{"version", "2.0"}, {"generator", "etendue-sculpt --kind robot"}};
    glb_["extensionsUsed"] =
        Json::Array{"KHR_materials_clearcoat", "KHR_materials_emissive_strength", "KHR_materials_sheen"};
    glb_["scenes"] = Json::Array{Json{{"nodes", top_}}};
    glb_["scene"] = 0;
    return std::move(glb_);
  }

 private:
  static Json surface(Vec3 color, double metallic, double roughness) {
    return {{"baseColorFactor", Json{color.x, color.y, color.z, 1.0}},
            {"metallicFactor", metallic},
            {"roughnessFactor", roughness}};
  }
  std::size_t metal(Vec3 color, double roughness) {
    return glb_.add_material({{"pbrMetallicRoughness", surface(color, 1.0, roughness)}});
  }
  std::size_t lacquer(Vec3 color) {
    const Json coat = {{"clearcoatFactor", 1.0}, {"clearcoatRoughnessFactor", 0.12}};
    return glb_.add_material(
        {{"pbrMetallicRoughness", surface(color, 0.0, 0.5)}, {"extensions", Json{{"KHR_materials_clearcoat", coat}}}});
  }
  std::size_t glow(Vec3 color, double strength) {
    const Json extension = {{"emissiveStrength", strength}};
    return glb_.add_material({{"pbrMetallicRoughness", surface({0, 0, 0}, 0.0, 1.0)},
                              {"emissiveFactor", numbers(color)},
                              {"extensions", Json{{"KHR_materials_emissive_strength", extension}}}});
  }
  std::size_t painted(const std::string& picture, double roughness) {
    Json base = surface({1, 1, 1}, 0.0, roughness);
    base["baseColorTexture"] = Json{{"index", glb_.add_texture(encode_png(make_picture(picture, 512)))}};
    return glb_.add_material({{"pbrMetallicRoughness", base}});
  }

  /// A node of one mesh. Parts of an arm are given to its node, all others stand for themselves.
  std::size_t part(const Mesh& mesh, std::size_t material, Vec3 place, const Json& turned = {}) {
    Json node = {{"mesh", glb_.add_mesh(mesh, material)}, {"translation", numbers(place)}};
    if (!turned.is_null()) node["rotation"] = turned;
    return glb_.add_node(node);
  }
  void stand(const Mesh& mesh, std::size_t material, Vec3 place, const Json& turned = {}) {
    top_.push_back(part(mesh, material, place, turned));
  }

  void body() {
    const Json forward = rotation({1, 0, 0}, 0.25);
    for (const double side : {-1.0, 1.0}) {
      stand(box({0.25, 0.13, 0.36}, 0.1), blue_, {0.33 * side, 0.13, 0.07});
      stand(drum(0.12, 0.2, 0.03), steel_, {0.33 * side, 0.44, 0.0});
      stand(ring(0.12, 0.045), brass_, {0.33 * side, 0.36, 0.0});
      stand(ring(0.12, 0.045), brass_, {0.33 * side, 0.5, 0.0});
    }
    stand(box({0.60, 0.52, 0.40}, 0.13), red_, {0.0, 1.14, 0.0});
    stand(box({0.40, 0.28, 0.03}, 0.025), cream_, {0.0, 1.2, 0.40});
    const std::size_t lights[] = {glow({1.0, 0.10, 0.05}, 3.0), glow({1.0, 0.55, 0.08}, 3.0),
                                  glow({0.10, 0.9, 0.25}, 2.0)};
    for (int i = 0; i < 3; ++i) {
      const double x = 0.2 * (i - 1);
      stand(ring(0.065, 0.02), steel_, {x, 1.33, 0.43}, forward);
      stand(drum(0.05, 0.05, 0.05), lights[i], {x, 1.33, 0.43});
      stand(box({0.28, 0.018, 0.02}, 0.015), dark_, {0.0, 1.18 - 0.07 * i, 0.43});
    }
    for (const double x : {-0.5, 0.5})
      for (const double y : {0.74, 1.54}) stand(drum(0.03, 0.03, 0.03), brass_, {x, y, 0.375});
  }

  void head() {
    const Json forward = rotation({1, 0, 0}, 0.25), sideways = rotation({0, 0, 1}, 0.25);
    stand(drum(0.17, 0.1, 0.03), steel_, {0.0, 1.72, 0.0});
    stand(ring(0.17, 0.04), brass_, {0.0, 1.74, 0.0});
    stand(box({0.46, 0.34, 0.36}, 0.12), blue_, {0.0, 2.12, 0.0});
    const std::size_t eye = glow({1.0, 0.62, 0.20}, 2.4), tip = glow({1.0, 0.12, 0.05}, 6.0);
    for (const double side : {-1.0, 1.0}) {
      stand(ring(0.125, 0.035), brass_, {0.19 * side, 2.2, 0.36}, forward);
      stand(drum(0.1, 0.1, 0.1), eye, {0.19 * side, 2.2, 0.34});
      stand(drum(0.14, 0.05, 0.03), brass_, {0.48 * side, 2.12, 0.0}, sideways);
    }
    for (int i = -2; i <= 2; ++i) stand(box({0.03, 0.05, 0.02}, 0.015), cream_, {0.08 * i, 1.93, 0.36});
    stand(drum(0.02, 0.16, 0.01), steel_, {0.0, 2.58, 0.0});
    stand(drum(0.07, 0.07, 0.07), tip, {0.0, 2.78, 0.0});
    stand(drum(0.09, 0.03, 0.02), brass_, {0.0, 2.46, 0.0});
  }

  /// On one side, raised by so many turns from where it hangs.
  void arm(double side, double raised) {
    Json parts = Json::array();
    parts.push_back(part(drum(0.17, 0.17, 0.17), brass_, {0, 0, 0}));
    parts.push_back(part(drum(0.085, 0.26, 0.03), steel_, {0, -0.3, 0}));
    parts.push_back(part(ring(0.09, 0.04), dark_, {0, -0.24, 0}));
    parts.push_back(part(ring(0.09, 0.04), dark_, {0, -0.36, 0}));
    parts.push_back(part(drum(0.15, 0.16, 0.05), red_, {0, -0.58, 0}));
    parts.push_back(part(ring(0.12, 0.05), steel_, {0, -0.86, 0}, rotation({1, 0, 0}, 0.25)));
    Json shoulder = {{"translation", numbers({0.76 * side, 1.46, 0.0})},
                     {"rotation", rotation({0, 0, 1}, side * raised)},
                     {"children", parts}};
    top_.push_back(glb_.add_node(shoulder));
  }

  void surroundings() {
    const std::size_t wood = painted("wood", 0.4), cloth = painted("cloth", 0.9);
    stand(box({3.0, 0.1, 2.2}, 0.05), wood, {0.2, -0.1, 0.3});
    stand(box({0.27, 0.27, 0.27}, 0.05), cream_, {1.42, 0.27, 0.35}, rotation({0, 1, 0}, 0.06));
    stand(box({0.27, 0.27, 0.27}, 0.05), cloth, {2.0, 0.27, -0.2}, rotation({0, 1, 0}, -0.09));
    stand(box({0.24, 0.24, 0.24}, 0.05), red_, {1.66, 0.78, 0.1}, rotation({0, 1, 0}, 0.15));
    const Json sheen = {{"sheenColorFactor", numbers({0.7, 0.7, 0.9})}, {"sheenRoughnessFactor", 0.4}};
    const std::size_t felt = glb_.add_material({{"pbrMetallicRoughness", surface({0.05, 0.09, 0.25}, 0.0, 0.9)},
                                                {"extensions", Json{{"KHR_materials_sheen", sheen}}}});
    stand(drum(0.34, 0.34, 0.34), felt, {-1.5, 0.34, 0.2});
    const std::size_t paper = glb_.add_material({{"pbrMetallicRoughness", surface({0.16, 0.30, 0.30}, 0.0, 0.9)}});
    stand(box({30.0, 12.0, 0.1}, 0.05), paper, {0, 6.0, -5.0});
    stand(box({30.0, 0.1, 30.0}, 0.05), paper, {0, -0.6, 0});
    stand(box({1.7, 1.7, 0.02}, 0.01), glow({1.0, 0.92, 0.82}, 14.0), {4.6, 5.4, 4.0}, facing(0.135, -0.1));
    stand(box({0.8, 2.2, 0.02}, 0.01), glow({0.62, 0.80, 1.0}, 9.0), {-5.2, 2.6, 0.6}, rotation({0, 1, 0}, 0.2));
  }

  /// Turned about y and then tilted.
  static Json facing(double turns, double tilt) {
    const double s = sin_turns(0.5 * turns), c = cos_turns(0.5 * turns);
    const double t = sin_turns(0.5 * tilt), d = cos_turns(0.5 * tilt);
    return Json{c * t, s * d, -s * t, c * d};
  }

  void view() {
    glb_["cameras"] = Json::Array{Json{
        {"type", "perspective"}, {"perspective", Json{{"aspectRatio", 16.0 / 9.0}, {"yfov", 0.45}, {"znear", 0.1}}}}};
    top_.push_back(glb_.add_node(
        {{"camera", 0}, {"translation", numbers({0.25, 1.75, 7.4})}, {"rotation", facing(0.0, -0.0095)}}));
  }

  Glb glb_;
  Json top_ = Json::array();
  std::size_t red_, blue_, cream_, steel_, brass_, dark_;
};

}  // namespace

Glb robot() {
  return Toy().build();
}

}  // namespace etendue::sculpt
