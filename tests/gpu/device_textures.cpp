/// Texture lookups on the device against the reference: every format, wrap and filter, sizes that divide nothing,
/// transforms, spheres, attributes, through texel buffers and through storage buffers.

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/gtc/packing.hpp>

#include "device_test.h"
#include "kernels_storage.h"
#include "reference/texture.h"

namespace etendue::test {
namespace {

class DeviceTextures : public DeviceTest {};

std::shared_ptr<Bitmap> random_bitmap(Random& random, std::uint32_t width, std::uint32_t height) {
  auto bitmap = std::make_shared<Bitmap>();
  bitmap->width = width;
  bitmap->height = height;
  bitmap->channels = 1 + random.below(4);
  bitmap->format = static_cast<BitmapFormat>(random.below(3));
  bitmap->color_space = random.below(2) == 0 ? ColorSpace::linear : ColorSpace::srgb;
  bitmap->texels.resize(bitmap->row_bytes() * height);
  std::size_t at = 0;
  while (at < bitmap->texels.size()) {
    const float value = random.unit();
    const std::uint32_t half = glm::packHalf2x16(glm::vec2(value, 0.0f)), word = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t code = random.below(256);
    const std::uint32_t* stored = bitmap->format == BitmapFormat::u8    ? &code
                                  : bitmap->format == BitmapFormat::f16 ? &half
                                                                        : &word;
    std::memcpy(&bitmap->texels[at], stored, bytes_of(bitmap->format));
    at += bytes_of(bitmap->format);
  }
  return bitmap;
}

const Cylinder kCylinder{{0.3, -0.2, 0.1}, {1.0, 0.5, -1.4}, 0.4};

// One triangle with coordinates up to `reach`, with colours; a sphere turned somehow, a mirrored disk and a cylinder;
// all of it untextured so far.
Scene bodies(Random& random, float reach) {
  Scene scene;
  TriangleMesh mesh{
      .positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}}, .normals = {}, .triangles = {{0, 1, 2}, {3, 2, 1}}};
  for (int set = 0; set < 2; ++set) {
    auto& uvs = mesh.uv_sets.emplace_back();
    for (int i = 0; i < 4; ++i) uvs.emplace_back(random.uniform(-reach, reach), random.uniform(-reach, reach));
  }
  for (int i = 0; i < 4; ++i) mesh.vertex_colors.emplace_back(random.unit(), random.unit(), random.unit());
  for (int i = 0; i < 2; ++i) mesh.face_colors.emplace_back(random.unit(), random.unit(), random.unit());
  scene.add(mesh);
  Instance mirrored = scene.instances[0];
  mirrored.world_from_object[0][0] = -1.0;
  scene.instances.push_back(mirrored);
  const glm::dvec3 z = random.direction(), x = glm::normalize(glm::cross(z, glm::dvec3(0.3, 1.0, 0.2)));
  Instance& sphere = scene.add(Sphere{});
  const glm::dmat4 place =
      glm::dmat4(glm::dvec4(2.0 * x, 0), glm::dvec4(2.0 * glm::cross(z, x), 0), glm::dvec4(2.0 * z, 0), {3, 4, 5, 1});
  sphere.world_from_object = place;
  scene.add(Disk{}).world_from_object = place * glm::dmat4({1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, -1, 0}, {0, 0, 0, 1});
  Instance& cylinder = scene.add(kCylinder);
  cylinder.world_from_object = place;
  cylinder.flip_normals = random.below(2) == 0;
  return scene;
}

// The point of a surface that a case means, and what it hands to the kernel.
reference::Surface surface_of(const Scene& scene, Random& random, gpu::TextureCase& c) {
  reference::Surface surface{.instance = c.instance, .primitive = c.primitive, .weights = glm::dvec3(c.weights)};
  const Instance& instance = scene.instances[c.instance];
  const glm::dmat4& m = instance.world_from_object;
  if (std::holds_alternative<Disk>(scene.shape_of(instance)))  // mirrored: its half axes are the other way round
    surface.p = glm::dvec3(m * glm::dvec4(surface.weights.z, surface.weights.y, 0.0, 1.0));
  if (std::holds_alternative<Cylinder>(scene.shape_of(instance))) {
    const double v = static_cast<double>(c.weights.y);
    c.weights = glm::vec3(1.0f - c.weights.y, c.weights.y, 0.0f);
    const glm::dvec3 axis = kCylinder.p1 - kCylinder.p0;
    const glm::dvec3 out = glm::normalize(glm::cross(axis, glm::dvec3(random.direction())));
    surface.p = glm::dvec3(m * glm::dvec4(kCylinder.p0 + v * axis + kCylinder.radius * out, 1.0));
    c.n = glm::vec3((instance.flip_normals ? -1.0 : 1.0) * glm::normalize(glm::dmat3(m) * out));
  }
  surface.ns = glm::normalize(glm::dvec3(c.n));
  return surface;
}

// Points of the triangles of the first two instances.
std::vector<gpu::TextureCase> cases_on_triangles(Random& random) {
  std::vector<gpu::TextureCase> cases(64);
  for (gpu::TextureCase& c : cases) {
    c.instance = random.below(2);
    c.primitive = random.below(2);
    const float a = random.unit(), b = (1.0f - a) * random.unit();
    c.weights = {a, b, 1.0f - a - b};
  }
  return cases;
}

reference::Surface surface_on_triangle(const gpu::TextureCase& c) {
  return {.instance = c.instance, .primitive = c.primitive, .weights = glm::dvec3(c.weights)};
}

glm::dmat3 random_transform(Random& random) {
  const auto entry = [&] { return static_cast<double>(random.uniform(-2.0f, 2.0f)); };
  return {entry(), entry(), 0.0, entry(), entry(), 0.0, entry(), entry(), 1.0};
}

void use(Scene& scene) {
  for (Material& material : scene.materials) {
    auto& albedo = std::get<DiffuseBsdf>(material.bsdf).albedo;
    albedo.texture = std::uint32_t{0};
  }
}

// What the reference says nearby: a device's coordinates are as exact as single precision, and a texel may begin there.
struct Bracket {
  glm::dvec4 low{INFINITY}, high{-INFINITY};
};
Bracket around(const Scene& scene, Texture texture, const reference::Surface& surface, double error) {
  Bracket bracket;
  const glm::dmat3 transform = texture.uv_transform;
  for (const glm::dvec2& step : {glm::dvec2(0, 0), {-1, -1}, {-1, 1}, {1, -1}, {1, 1}}) {
    texture.uv_transform[2] = transform[2] + error * glm::dvec3(step, 0.0);
    const glm::dvec4 value = reference::texture_value(scene, texture, surface);
    bracket.low = glm::min(bracket.low, value);
    bracket.high = glm::max(bracket.high, value);
  }
  return bracket;
}

double reach_of(const Scene& scene, const Texture& texture) {
  double uv = 1.0;
  for (const Shape& shape : scene.shapes) {
    if (const auto* mesh = std::get_if<TriangleMesh>(&shape)) {
      for (const glm::vec2& p : mesh->uv_sets[texture.uv_set])
        uv = std::max({uv, std::abs(static_cast<double>(p.x)), std::abs(static_cast<double>(p.y))});
    }
  }
  const glm::dmat3& m = texture.uv_transform;
  double sum = 1.0;
  for (int row = 0; row < 2; ++row)
    sum = std::max(sum, uv * (std::abs(m[0][row]) + std::abs(m[1][row])) + std::abs(m[2][row]));
  return sum;
}

TEST_F(DeviceTextures, LookupsAreThoseOfTheReference) {
  Random random(5);
  struct Size {
    std::uint32_t width, height;
  };
  const std::vector<Size> sizes = {{1, 1}, {3, 1}, {1, 2}, {2, 2}, {5, 3}, {16, 16}, {257, 63}, {8191, 37}};
  for (std::uint32_t round = 0; round < 96; ++round) {
    const Size size = sizes[round % sizes.size()];
    // So many texels a unit that rounding stays within one.
    const float reach = size.width > 1000 || round % 3 == 0 ? 1.0f : round % 3 == 1 ? 4.0f : 300.0f;
    Scene scene = bodies(random, reach);
    Texture& texture = scene.textures.emplace_back();
    texture.uv_set = 0;
    if (round % 2 == 0) texture.uv_transform = random_transform(random);
    if (round % 12 == 11) {
      texture.source = CheckerboardTexture{{0.1, 0.5, 0.9}, {0.7, 0.2, 0.3}};
    } else {
      scene.bitmaps.push_back(random_bitmap(random, size.width, size.height));
      texture.source = BitmapTexture{.bitmap = 0,
                                     .wrap_u = static_cast<TextureWrap>(random.below(3)),
                                     .wrap_v = static_cast<TextureWrap>(random.below(3)),
                                     .filter = static_cast<TextureFilter>(random.below(2)),
                                     .color_space = {}};
    }
    use(scene);
    const CompiledScene compiled = compile_scene(scene);
    std::vector<gpu::TextureCase> cases(256);
    std::vector<reference::Surface> surfaces;
    for (gpu::TextureCase& c : cases) {
      c.instance = random.below(5);
      c.primitive = c.instance < 2 ? random.below(2) : 0u;
      const float a = random.unit(), b = (1.0f - a) * random.unit();
      c.weights = {a, b, 1.0f - a - b};
      c.n = glm::vec3(random.direction());
      surfaces.push_back(surface_of(scene, random, c));
    }
    const double error = 4e-7 * reach_of(scene, texture);
    // What rounding does between two texels, at worst near the centre of one, where none of the neighbours is so low.
    const double tolerance = 2e-6 + 0.5 * error * std::max(size.width, size.height);
    for (const TableLoads loads : {TableLoads::texel_buffer, TableLoads::storage_buffer}) {
      const bool texels = loads == TableLoads::texel_buffer;
      KernelRun kernel{texels ? kernels::textures : kernels::textures_storage, "textures", &compiled};
      kernel.loads = loads;
      const auto answers = run<gpu::TextureAnswer>(kernel, cases);
      for (std::size_t i = 0; i < cases.size(); ++i) {
        const gpu::TextureCase& c = cases[i];
        const Bracket wanted =
            around(scene, scene.textures[0], surfaces[i], c.instance >= 2 ? 20.0 * error : error);  // poles
        for (int k = 0; k < 4; ++k) {
          ASSERT_GE(static_cast<double>(answers[i].value[k]), wanted.low[k] - tolerance)
              << round << " " << i << " " << k << " instance " << c.instance;
          ASSERT_LE(static_cast<double>(answers[i].value[k]), wanted.high[k] + tolerance)
              << round << " " << i << " " << k << " instance " << c.instance;
        }
      }
    }
  }
}

// Dark codes too, whose light is small, to what single precision says of a number.
TEST_F(DeviceTextures, EveryCodeOfSrgbIsItsLight) {
  Random random(8);
  Scene scene = bodies(random, 1.0f);
  auto& mesh = std::get<TriangleMesh>(scene.shapes[0]);
  mesh.uv_sets[0] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  Bitmap codes{.width = 256, .height = 1, .channels = 1, .format = BitmapFormat::u8, .color_space = ColorSpace::srgb};
  for (int code = 0; code < 256; ++code) codes.texels.push_back(static_cast<std::byte>(code));
  scene.bitmaps.push_back(std::make_shared<Bitmap>(codes));
  scene.textures.push_back({.source = BitmapTexture{.bitmap = 0, .filter = TextureFilter::nearest, .color_space = {}}});
  use(scene);
  const CompiledScene compiled = compile_scene(scene);
  std::vector<gpu::TextureCase> cases(256);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const float u = (static_cast<float>(i) + 0.5f) / 256.0f;
    cases[i].weights = {1.0f - u, u, 0.0f};
  }
  const auto answers = run<gpu::TextureAnswer>({kernels::textures, "textures", &compiled}, cases);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const double code = static_cast<double>(i) / 255.0;
    const double light = code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
    EXPECT_NEAR(static_cast<double>(answers[i].value.x), light, 6e-7 * light) << "code " << i;
  }
}

// Pictures times colours of vertices, cut by their alpha or multiplied with it.
TEST_F(DeviceTextures, DerivedOnesAreThoseOfTheReference) {
  Random random(7);
  for (std::uint32_t round = 0; round < 16; ++round) {
    Scene scene = bodies(random, 1.0f);
    scene.instances.resize(2);  // other shapes have no colours
    auto& mesh = std::get<TriangleMesh>(scene.shapes[0]);
    if (round % 2 == 0) {
      for (int i = 0; i < 4; ++i) mesh.vertex_alphas.push_back(random.unit());
    }
    const bool attribute = round >= 12;
    Texture texture{.source = CheckerboardTexture{glm::dvec3(0.75, 0.5, 0.25), glm::dvec3(0.25, 0.75, 1.0)}};
    if (attribute) texture.source = AttributeTexture{};
    if (round < 8) {
      scene.bitmaps.push_back(random_bitmap(random, 2, 2));
      texture.source = BitmapTexture{.bitmap = 0};
    }
    texture.vertex_tint = !attribute;
    if (round / 2 % 2 == 0) texture.alpha_cutoff = 0.5;
    texture.premultiplied = round / 4 % 2 == 0;
    scene.textures.push_back(texture);
    use(scene);
    const CompiledScene compiled = compile_scene(scene);
    const std::vector<gpu::TextureCase> cases = cases_on_triangles(random);
    const auto answers = run<gpu::TextureAnswer>({kernels::textures, "textures", &compiled}, cases);
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const reference::Surface surface = surface_on_triangle(cases[i]);
      Texture uncut = texture;
      uncut.alpha_cutoff.reset();
      uncut.premultiplied = false;
      // Single precision may fall on the other side.
      if (std::abs(reference::texture_value(scene, uncut, surface).a - 0.5) < 1e-4) continue;
      const Bracket wanted = around(scene, texture, surface, 1e-5);
      for (int k = 0; k < 4; ++k) {
        ASSERT_GE(static_cast<double>(answers[i].value[k]), wanted.low[k] - 1e-4) << round << " " << i << " " << k;
        ASSERT_LE(static_cast<double>(answers[i].value[k]), wanted.high[k] + 1e-4) << round << " " << i << " " << k;
      }
    }
  }
}

// Checkerboards of pictures and of another checkerboard, each with a transform of its own.
TEST_F(DeviceTextures, CheckerboardsOfTexturesAreThoseOfTheReference) {
  Random random(11);
  std::size_t compared = 0;
  for (std::uint32_t round = 0; round < 8; ++round) {
    Scene scene = bodies(random, 1.0f);
    CheckerboardTexture inner{{0.9, 0.5, 0.3}, {0.2, 0.7, 0.8}};
    inner.texture1 = 0;
    CheckerboardTexture outer{{0.5, 0.8, 1.0}, {0.6, 0.4, 0.9}};
    if (round % 2 == 0) outer.texture0 = 1;
    outer.texture1 = 2;
    for (std::uint32_t i = 0; i < 2; ++i) {
      scene.bitmaps.push_back(random_bitmap(random, 2 + i, 3));
      scene.textures.push_back({.source = BitmapTexture{.bitmap = i}, .uv_transform = random_transform(random)});
    }
    for (const CheckerboardTexture& board : {inner, outer})
      scene.textures.push_back({.source = board, .uv_transform = random_transform(random)});
    use(scene);
    CompiledScene compiled = compile_scene(scene);
    // The kernel looks at the first texture: the outermost, from here on.
    std::ranges::reverse(compiled.textures.textures);
    for (std::size_t i = 0; i < 2; ++i) {
      for (gpu::uint* row : {&compiled.textures.textures[i].first, &compiled.textures.textures[i].width})
        *row = *row == gpu::kNone ? gpu::kNone : 3u - *row;
    }
    std::vector<gpu::TextureCase> cases(128);
    std::vector<reference::Surface> surfaces;
    for (gpu::TextureCase& c : cases) {
      c.instance = random.below(5);
      c.primitive = c.instance < 2 ? random.below(2) : 0u;
      const float a = random.unit(), b = (1.0f - a) * random.unit();
      c.weights = {a, b, 1.0f - a - b};
      c.n = glm::vec3(random.direction());
      surfaces.push_back(surface_of(scene, random, c));
    }
    const auto answers = run<gpu::TextureAnswer>({kernels::textures, "textures", &compiled}, cases);
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const glm::dvec4 wanted = reference::texture_value(scene, scene.textures[3], surfaces[i]);
      // Single precision may fall into the next square.
      Scene moved = scene;
      bool near_edge = false;
      for (const glm::dvec2& step : {glm::dvec2(-1, -1), {-1, 1}, {1, -1}, {1, 1}}) {
        for (std::size_t k = 2; k < 4; ++k)
          moved.textures[k].uv_transform[2] = scene.textures[k].uv_transform[2] + 1e-4 * glm::dvec3(step, 0.0);
        near_edge |= reference::texture_value(moved, moved.textures[3], surfaces[i]) != wanted;
      }
      if (near_edge) continue;
      ++compared;
      for (int k = 0; k < 4; ++k)
        ASSERT_NEAR(static_cast<double>(answers[i].value[k]), wanted[k], 2e-4) << round << " " << i << " " << k;
    }
  }
  EXPECT_GT(compared, 900u);
}

TEST_F(DeviceTextures, AttributesAreThoseOfTheReference) {
  Random random(6);
  for (const auto source : {AttributeTexture::Source::vertex_color, AttributeTexture::Source::face_color}) {
    Scene scene = bodies(random, 1.0f);
    scene.instances.resize(2);  // other shapes have no colours
    scene.textures.push_back({.source = AttributeTexture{source}});
    scene.textures.push_back({.source = CheckerboardTexture{}, .uv_set = 1});  // so that sets lie before the colours
    std::get<DiffuseBsdf>(scene.materials[0].bsdf).albedo.texture = std::uint32_t{0};
    scene.emitters.push_back({ColorParameter(glm::dvec3(1.0), 1)});
    scene.instances[0].emitter = 0;
    const CompiledScene compiled = compile_scene(scene);
    const std::vector<gpu::TextureCase> cases = cases_on_triangles(random);
    const auto answers = run<gpu::TextureAnswer>({kernels::textures, "textures", &compiled}, cases);
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const reference::Surface surface = surface_on_triangle(cases[i]);
      const glm::dvec4 wanted = reference::texture_value(scene, scene.textures[0], surface);
      for (int k = 0; k < 4; ++k) ASSERT_NEAR(static_cast<double>(answers[i].value[k]), wanted[k], 1e-6);
    }
  }
}

}  // namespace
}  // namespace etendue::test
