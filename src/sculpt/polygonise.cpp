#include "sculpt/polygonise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/parallel.h"

namespace etendue::sculpt {
namespace {

// Space is divided into the tetrahedra of a body-centred cubic lattice, whose points are the corners and centres of a
// cubic grid. With tetrahedra there are no ambiguous cases, so the mesh is always closed and manifold; and because all
// of them have the same, nearly regular shape, there are fewer slivers than with cubes cut into five or six tetrahedra.
// In units of half a cube edge, corners have even coordinates and centres odd ones.
struct Lattice {
  Vec3 origin;
  double step;  // half a cube edge
  std::array<int, 3> cubes;
};

using Point = std::array<int, 3>;

constexpr int kBlock = 8;  // cubes along an edge of a block; blocks are culled and processed as a whole

// An edge of the lattice as one sortable word: its lower end and one of seven directions.
using Edge = std::uint64_t;
constexpr std::array<Point, 7> kDirections{
    {{0, 0, 2}, {0, 2, 0}, {2, 0, 0}, {1, 1, 1}, {1, 1, -1}, {1, -1, 1}, {1, -1, -1}}};

Edge make_edge(Point a, Point b) {
  if (b < a) std::swap(a, b);
  const Point d{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const auto direction = static_cast<Edge>(std::find(kDirections.begin(), kDirections.end(), d) - kDirections.begin());
  const auto bits = [](int coordinate) { return static_cast<Edge>(coordinate); };
  return ((bits(a[0]) << 20 | bits(a[1])) << 20 | bits(a[2])) << 3 | direction;
}

std::pair<Point, Point> ends(Edge edge) {
  const auto coordinate = [edge](int shift) { return static_cast<int>(edge >> shift & 0xfffff); };
  const Point a{coordinate(43), coordinate(23), coordinate(3)};
  const Point d = kDirections[edge & 7];
  return {a, {a[0] + d[0], a[1] + d[1], a[2] + d[2]}};
}

Vec3 position(const Lattice& lattice, Point p) {
  return lattice.origin + lattice.step * Vec3{double(p[0]), double(p[1]), double(p[2])};
}

using EdgeTriangle = std::array<Edge, 3>;

struct Vertex {
  Point point;
  double value;
};

// Adds the part of the surface inside one tetrahedron: nothing, a triangle or a quad, facing the positive side.
void march(std::array<Vertex, 4> v, std::vector<EdgeTriangle>& out) {
  std::stable_partition(v.begin(), v.end(), [](const Vertex& a) { return a.value < 0.0; });
  const auto inside = std::count_if(v.begin(), v.end(), [](const Vertex& a) { return a.value < 0.0; });
  if (inside == 0 || inside == 4) return;
  const auto delta = [&](int i, int k) { return v[i].point[k] - v[0].point[k]; };
  const int det = delta(1, 0) * (delta(2, 1) * delta(3, 2) - delta(2, 2) * delta(3, 1)) -
                  delta(1, 1) * (delta(2, 0) * delta(3, 2) - delta(2, 2) * delta(3, 0)) +
                  delta(1, 2) * (delta(2, 0) * delta(3, 1) - delta(2, 1) * delta(3, 0));
  const auto edge = [&](int i, int j) { return make_edge(v[i].point, v[j].point); };
  const auto emit = [&](Edge a, Edge b, Edge c) {
    out.push_back(det > 0 ? EdgeTriangle{a, b, c} : EdgeTriangle{a, c, b});
  };
  if (inside == 1) {
    emit(edge(0, 1), edge(0, 2), edge(0, 3));
  } else if (inside == 3) {
    emit(edge(3, 0), edge(3, 1), edge(3, 2));
  } else {
    emit(edge(0, 2), edge(0, 3), edge(1, 3));
    emit(edge(0, 2), edge(1, 3), edge(1, 2));
  }
}

// Field values of one block: corners 0…8 and centres 0…8 (the last row of centres belongs to the neighbours).
struct BlockValues {
  static constexpr int n = kBlock + 1;
  std::array<double, std::size_t{n} * n * n> corner, center;
  static int index(int i, int j, int k) { return (i * n + j) * n + k; }
};

void march_block(const Lattice& lattice, Point first, const BlockValues& values, std::vector<EdgeTriangle>& out) {
  const auto corner = [&](int i, int j, int k) {
    return Vertex{{2 * (first[0] + i), 2 * (first[1] + j), 2 * (first[2] + k)},
                  values.corner[BlockValues::index(i, j, k)]};
  };
  const auto center = [&](int i, int j, int k) {
    return Vertex{{2 * (first[0] + i) + 1, 2 * (first[1] + j) + 1, 2 * (first[2] + k) + 1},
                  values.center[BlockValues::index(i, j, k)]};
  };
  // Two neighbouring centres and an edge of the face between them form a tetrahedron; each cube owns its upper faces.
  for (int i = 0; i < kBlock; ++i)
    for (int j = 0; j < kBlock; ++j)
      for (int k = 0; k < kBlock; ++k) {
        if (first[0] + i >= lattice.cubes[0] || first[1] + j >= lattice.cubes[1] || first[2] + k >= lattice.cubes[2])
          continue;
        const Vertex here = center(i, j, k);
        const std::array<Vertex, 3> next{center(i + 1, j, k), center(i, j + 1, k), center(i, j, k + 1)};
        const std::array<std::array<Vertex, 4>, 3> face{
            {{corner(i + 1, j, k), corner(i + 1, j + 1, k), corner(i + 1, j + 1, k + 1), corner(i + 1, j, k + 1)},
             {corner(i, j + 1, k), corner(i, j + 1, k + 1), corner(i + 1, j + 1, k + 1), corner(i + 1, j + 1, k)},
             {corner(i, j, k + 1), corner(i + 1, j, k + 1), corner(i + 1, j + 1, k + 1), corner(i, j + 1, k + 1)}}};
        for (int axis = 0; axis < 3; ++axis)
          for (int e = 0; e < 4; ++e) march({here, next[axis], face[axis][e], face[axis][(e + 1) % 4]}, out);
      }
}

bool may_hold_surface(const Solid& solid, const Lattice& lattice, Point first) {
  constexpr int half = kBlock + 1;  // a block extends from its first corner to the centre beyond the last
  const Vec3 middle = position(lattice, {2 * first[0] + half, 2 * first[1] + half, 2 * first[2] + half});
  return std::abs(solid.value(middle)) <= solid.lipschitz * std::sqrt(3.0) * half * lattice.step;
}

std::vector<EdgeTriangle> march_lattice(const Solid& solid, const Lattice& lattice) {
  const auto blocks = [&](int axis) { return (lattice.cubes[axis] + kBlock - 1) / kBlock; };
  const int ny = blocks(1), nz = blocks(2);
  const auto count = static_cast<std::uint64_t>(blocks(0)) * ny * nz;
  std::vector<std::vector<EdgeTriangle>> parts(count);
  parallel_for(count, 4, [&](std::uint64_t begin, std::uint64_t end) {
    BlockValues values;
    for (std::uint64_t b = begin; b < end; ++b) {
      const auto block = static_cast<int>(b);
      const Point first{block / (ny * nz) * kBlock, block / nz % ny * kBlock, block % nz * kBlock};
      if (!may_hold_surface(solid, lattice, first)) continue;
      for (int i = 0; i <= kBlock; ++i)
        for (int j = 0; j <= kBlock; ++j)
          for (int k = 0; k <= kBlock; ++k) {
            const Point p{2 * (first[0] + i), 2 * (first[1] + j), 2 * (first[2] + k)};
            values.corner[BlockValues::index(i, j, k)] = solid.value(position(lattice, p));
            values.center[BlockValues::index(i, j, k)] = solid.value(position(lattice, {p[0] + 1, p[1] + 1, p[2] + 1}));
          }
      march_block(lattice, first, values, parts[b]);
    }
  });
  std::vector<EdgeTriangle> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

Lattice make_lattice(const Solid& solid, double cube) {
  const Vec3 size = solid.upper - solid.lower;
  const auto count = [cube](double extent) { return static_cast<int>(std::ceil(extent / cube)) + 3; };
  const Vec3 margin{cube, cube, cube};  // tetrahedra extend half a cube beyond the cubes that own them
  return {solid.lower - margin, 0.5 * cube, {count(size.x), count(size.y), count(size.z)}};
}

Vec3 crossing(const Solid& solid, const Lattice& lattice, Edge edge) {
  const auto [a, b] = ends(edge);
  const Vec3 pa = position(lattice, a), pb = position(lattice, b);
  const double fa = solid.value(pa), fb = solid.value(pb);
  const double t =
      std::clamp(fa / (fa - fb), 0.05, 0.95);  // keeps vertices away from lattice points, where several edges meet
  return pa + t * (pb - pa);
}

Vec3 gradient(const Solid& solid, Vec3 p, double h) {
  const auto slope = [&](Vec3 d) { return (solid.value(p + d) - solid.value(p - d)) / (2.0 * h); };
  return {slope({h, 0, 0}), slope({0, h, 0}), slope({0, 0, h})};
}

std::vector<Vec3> neighbour_means(const Mesh& mesh) {
  std::vector<Vec3> sum(mesh.positions.size());
  std::vector<int> degree(mesh.positions.size());
  for (const auto& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) {  // counts each neighbour once, because a directed edge belongs to one triangle
      sum[t[i]] = sum[t[i]] + mesh.positions[t[(i + 1) % 3]];
      ++degree[t[i]];
    }
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = (1.0 / degree[i]) * sum[i];
  return sum;
}

// Keeps only the piece with the most triangles, which removes crumbs and hidden cavities.
void keep_largest_piece(Mesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& t : mesh.triangles) {
    parent[root(t[1])] = root(t[0]);
    parent[root(t[2])] = root(t[0]);
  }
  std::vector<std::uint32_t> size(parent.size());
  for (const auto& t : mesh.triangles) ++size[root(t[0])];
  const auto largest = static_cast<std::uint32_t>(std::max_element(size.begin(), size.end()) - size.begin());

  std::erase_if(mesh.triangles, [&](const auto& t) { return root(t[0]) != largest; });
  std::vector<std::uint32_t> renumbered(parent.size());
  std::vector<Vec3> kept;
  for (std::uint32_t i = 0; i < parent.size(); ++i)
    if (root(i) == largest) {
      renumbered[i] = static_cast<std::uint32_t>(kept.size());
      kept.push_back(mesh.positions[i]);
    }
  for (auto& t : mesh.triangles)
    for (auto& i : t) i = renumbered[i];
  mesh.positions = std::move(kept);
}

// The unsmoothed mesh, with one vertex for each lattice edge that crosses the surface.
Mesh extract(const Solid& solid, const Lattice& lattice) {
  const std::vector<EdgeTriangle> faces = march_lattice(solid, lattice);
  std::vector<Edge> edges;
  edges.reserve(3 * faces.size());
  for (const auto& face : faces) edges.insert(edges.end(), face.begin(), face.end());
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());

  Mesh mesh;
  mesh.positions.resize(edges.size());
  mesh.triangles.resize(faces.size());
  parallel_for(edges.size(), 4096, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = begin; i < end; ++i) mesh.positions[i] = crossing(solid, lattice, edges[i]);
  });
  parallel_for(faces.size(), 4096, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = begin; i < end; ++i)
      for (int k = 0; k < 3; ++k) {
        const auto at = std::lower_bound(edges.begin(), edges.end(), faces[i][k]);
        mesh.triangles[i][k] = static_cast<std::uint32_t>(at - edges.begin());
      }
  });
  keep_largest_piece(mesh);
  return mesh;
}

// Makes triangles more regular: moves each vertex toward the mean of its neighbours, and then back onto the surface.
void relax(const Solid& solid, double cube, Mesh& mesh) {
  const std::vector<Vec3> middle = neighbour_means(mesh);
  parallel_for(mesh.positions.size(), 4096, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = begin; i < end; ++i) {
      const Vec3 p = 0.4 * mesh.positions[i] + 0.6 * middle[i];
      const Vec3 g = gradient(solid, p, 0.1 * cube);
      const double steepness = std::max(dot(g, g), 0.05);
      const Vec3 back = (-solid.value(p) / steepness) * g;
      const double size = length(back);
      mesh.positions[i] = p + (size > 0.3 * cube ? 0.3 * cube / size : 1.0) * back;
    }
  });
}

// Vertex normals are the area-weighted means of the triangles' normals. In creases, the gradient of the field would
// more often contradict the triangles.
void set_normals(Mesh& mesh) {
  mesh.normals.assign(mesh.positions.size(), Vec3{});
  for (const auto& t : mesh.triangles) {
    const Vec3 n = cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
    for (const auto i : t) mesh.normals[i] = mesh.normals[i] + n;
  }
  for (Vec3& n : mesh.normals) n = normalize(n);
}

// Creases that are finer than the lattice leave a few folded triangles. Their vertices are moved to the mean of their
// neighbours until triangles and vertex normals agree, at most eight times; check_closed makes the final check.
void untangle(Mesh& mesh) {
  for (int pass = 0; pass < 8; ++pass) {
    set_normals(mesh);
    std::vector<char> folded(mesh.positions.size(), 0);
    bool any = false;
    for (const auto& t : mesh.triangles)
      if (faces_away(mesh, t)) {
        any = true;
        for (const auto i : t) folded[i] = 1;
      }
    if (!any) return;
    const std::vector<Vec3> middle = neighbour_means(mesh);
    for (std::size_t i = 0; i < folded.size(); ++i)
      if (folded[i]) mesh.positions[i] = middle[i];
  }
}

}  // namespace

Mesh polygonise(const Solid& solid, std::uint64_t triangles) {
  const Vec3 size = solid.upper - solid.lower;
  double cube = std::max({size.x, size.y, size.z}) / 48.0;
  Mesh mesh;
  // The number of triangles is inversely proportional to the square of the cube's size, so two or three guesses
  // suffice. If the mesh is too coarse for this, small steps find a number that is large enough.
  for (int guess = 0;; ++guess) {
    mesh = extract(solid, make_lattice(solid, cube));
    const double ratio = static_cast<double>(mesh.triangles.size()) / static_cast<double>(triangles);
    if (ratio >= 1.0 && (ratio < 1.05 || guess > 5)) break;
    cube *= guess > 5 ? 0.97 : std::sqrt(std::max(ratio, 0.01) / 1.01);
  }
  for (int pass = 0; pass < 4; ++pass) relax(solid, cube, mesh);
  untangle(mesh);
  return mesh;
}

}  // namespace etendue::sculpt
