/// Materials and textures of glTF assets.

#include "formats/gltf/gltf_textures.h"
#include "formats/mitsuba/mitsuba_writer.h"
#include "gltf_files.h"
#include "image/bitmap_file.h"
#include "image/decode.h"
#include "scene/texture_facts.h"

namespace etendue::testing {
namespace {

/// A PNG of 2 × 1 texels of RGBA.
std::vector<std::uint8_t> picture(const std::vector<std::uint8_t>& codes) {
  const TemporaryFolder folder;
  Bitmap bitmap{.width = 2, .height = 1, .channels = 4, .format = BitmapFormat::u8, .color_space = ColorSpace::srgb};
  for (const std::uint8_t code : codes) bitmap.texels.push_back(static_cast<std::byte>(code));
  write_bitmap(folder.path("p.png"), bitmap);
  std::ifstream file(folder.path("p.png"), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  return {bytes.begin(), bytes.end()};
}

/// A triangle of material 0 with two sets of coordinates and colours, and texture 0, a picture.
GltfRead with_material(const std::string& material, const std::string& primitive_more = "",
                       const std::string& texture = R"("source":0)", const ReadOptions& options = {},
                       const std::vector<std::uint8_t>& file = picture({255, 0, 0, 255, 0, 128, 255, 51})) {
  GltfBuffer buffer;
  buffer.accessor(right_triangle(), "VEC3", 3);
  buffer.accessor(std::vector<float>{0, 0, 1, 0, 0, 1}, "VEC2", 2);
  buffer.accessor(std::vector<float>{0, 0, 0, 1, 1, 0}, "VEC2", 2);
  buffer.accessor(std::vector<std::uint8_t>{255, 0, 0, 0, 51, 0, 255, 255, 255}, "VEC3", 3, R"(,"normalized":true)");
  const int image = buffer.view(file);
  buffer.add_accessor(R"("bufferView":0,"componentType":5126,"count":3,"type":"VEC3")");
  buffer.accessor(std::vector<float>(9, 1.0f), "VEC3", 3);
  buffer.accessor(std::vector<std::uint8_t>{255, 0, 0, 0, 0, 51, 0, 255, 255, 255, 255, 51}, "VEC4", 4,
                  R"(,"normalized":true)");
  return read_asset(
      glb(one_primitive(
              buffer,
              R"("attributes":{"POSITION":0,"TEXCOORD_0":1,"TEXCOORD_1":2)" + primitive_more + R"(},"material":0)",
              fmt::format(R"(,"materials":[{{{}}}],"textures":[{{{}}}],"images":[{{"bufferView":{}}}])", material,
                          texture, image)),
          buffer.bytes()),
      options);
}

/// The material that is reached through adapters, and those on the way.
struct Stack {
  std::vector<Adapter> adapters;
  Bsdf bsdf;
};
Stack stack_of(const Scene& scene) {
  Stack stack;
  std::uint32_t row = scene.instances.at(0).material;
  while (scene.materials.at(row).adapter) {
    stack.adapters.push_back(*scene.materials[row].adapter);
    each_choice(stack.adapters.back(), [&](std::uint32_t choice) { row = choice; });
  }
  stack.bsdf = scene.materials[row].bsdf;
  return stack;
}

std::string textured(const char* more = "") {
  return fmt::format(R"("pbrMetallicRoughness":{{"baseColorTexture":{{"index":0{}}}}})", more);
}

TEST(GltfMaterials, MetallicRoughness) {
  const GltfRead read = with_material(
      R"("pbrMetallicRoughness":{"baseColorFactor":[0.1,0.2,0.3,1],"metallicFactor":0.75,"roughnessFactor":0.5,"metallicRoughnessTexture":{"index":0,"texCoord":1}})");
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  const Stack stack = stack_of(*read.scene);
  ASSERT_EQ(stack.adapters.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<TwoSidedAdapter>(stack.adapters[0]));
  const auto& bsdf = std::get<GltfBsdf>(stack.bsdf);
  EXPECT_EQ(bsdf.base_color.value, glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_EQ(bsdf.metallic.value, 0.75);
  EXPECT_EQ(bsdf.metallic.channel, TextureChannel::blue);
  EXPECT_EQ(bsdf.roughness.value, 0.5);
  EXPECT_EQ(bsdf.roughness.channel, TextureChannel::green);
  const Texture& texture = read.scene->textures.at(*bsdf.roughness.texture);
  EXPECT_EQ(texture.uv_set, 1u);
  EXPECT_EQ(std::get<BitmapTexture>(texture.source).color_space, ColorSpace::linear);
  EXPECT_EQ(read.mesh().uv_sets.size(), 2u);
  EXPECT_EQ(read.mesh().uv_sets[0].at(2), glm::vec2(0, 0));  // v upward
}

TEST(GltfMaterials, LayersOfExtensions) {
  const GltfRead read = with_material(R"("extensions":{
      "KHR_materials_clearcoat":{"clearcoatFactor":0.5,"clearcoatRoughnessFactor":0.25,"clearcoatRoughnessTexture":{"index":0}},
      "KHR_materials_sheen":{"sheenColorFactor":[0.1,0.2,0.3],"sheenRoughnessFactor":0.5,"sheenRoughnessTexture":{"index":0}},
      "KHR_materials_specular":{"specularFactor":0.5,"specularColorFactor":[2,1,1],"specularTexture":{"index":0}},
      "KHR_materials_anisotropy":{"anisotropyStrength":0.75,"anisotropyRotation":1,"anisotropyTexture":{"index":0}},
      "KHR_materials_iridescence":{"iridescenceFactor":1,"iridescenceThicknessMinimum":100,"iridescenceThicknessMaximum":400,"iridescenceThicknessTexture":{"index":0}},
      "KHR_materials_ior":{"ior":1.25}})");
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  const auto b = std::get<GltfBsdf>(stack_of(*read.scene).bsdf);
  EXPECT_EQ(b.clearcoat.value, 0.5);
  EXPECT_EQ(b.clearcoat_roughness.channel, TextureChannel::green);
  EXPECT_EQ(b.sheen_color.value, glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_EQ(b.sheen_roughness.channel, TextureChannel::alpha);
  EXPECT_EQ(b.specular.channel, TextureChannel::alpha);
  EXPECT_EQ(b.specular_color.value, glm::dvec3(2, 1, 1));
  EXPECT_EQ(b.anisotropy.value, 0.75);
  EXPECT_EQ(b.anisotropy_rotation, -1.0);  // coordinates are mirrored
  EXPECT_EQ(b.anisotropy.channel, TextureChannel::blue);
  const Texture& directions = read.scene->textures.at(*b.anisotropy_directions.texture);
  const Bitmap& turned = *read.scene->bitmaps.at(std::get<BitmapTexture>(directions.source).bitmap);
  EXPECT_NEAR(turned.stored(0, 0, 1), 1.0, 1e-6);  // green is 0
  EXPECT_EQ(b.ior.value, 1.25);
  EXPECT_EQ(b.iridescence_thickness.value, 400.0);
  const Texture& film = read.scene->textures.at(*b.iridescence_thickness.texture);
  const Bitmap& thickness = *read.scene->bitmaps.at(std::get<BitmapTexture>(film.source).bitmap);
  EXPECT_NEAR(thickness.stored(0, 0, 0), 0.25, 0.002);  // green is 0
  EXPECT_NEAR(thickness.stored(1, 0, 0), 0.25 + 0.75 * 128.0 / 255.0, 0.002);
}

TEST(GltfMaterials, SheetsAndSolidsLetLightPass) {
  const std::string transmission =
      R"("pbrMetallicRoughness":{"metallicFactor":0},"extensions":{"KHR_materials_transmission":{"transmissionFactor":0.75})";
  const GltfRead sheet = with_material(transmission + "}");
  ASSERT_TRUE(sheet.scene.has_value()) << sheet.messages();
  const Stack thin = stack_of(*sheet.scene);
  EXPECT_TRUE(thin.adapters.empty());  // not two-sided
  EXPECT_TRUE(std::get<GltfBsdf>(thin.bsdf).thin);
  const GltfRead solid = with_material(
      transmission +
      R"(,"KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":2,"attenuationColor":[0,0.5,1]}})");
  ASSERT_TRUE(solid.scene.has_value()) << solid.messages();
  const auto b = std::get<GltfBsdf>(stack_of(*solid.scene).bsdf);
  EXPECT_FALSE(b.thin);
  EXPECT_EQ(b.transmission.value, 0.75);
  EXPECT_EQ(b.attenuation_distance, 2.0);
  EXPECT_EQ(b.attenuation_color.y, 0.5);
  EXPECT_GT(b.attenuation_color.x, 0.0);
}

TEST(GltfMaterials, MitsubaGetsItsNearestMaterial) {
  const TemporaryFolder folder;
  for (const char* material : {R"("pbrMetallicRoughness":{"metallicRoughnessTexture":{"index":0}})",
                               R"("pbrMetallicRoughness":{"metallicFactor":0},"extensions":{
                                  "KHR_materials_diffuse_transmission":{"diffuseTransmissionFactor":0.25}})"}) {
    const GltfRead read = with_material(material);
    ASSERT_TRUE(read.scene.has_value()) << read.messages();
    const auto differences = write_mitsuba_scene(folder.path("s.xml"), *read.scene, ExistingFiles::replace);
    EXPECT_NE(fmt::format("{}", fmt::join(differences, " ")).find("materials of glTF are written as principled"),
              std::string::npos);
    Diagnostics diagnostics;
    const auto file = read_scene_file(folder.path("s.xml"), {.strict = true}, diagnostics);
    ASSERT_TRUE(file.has_value()) << all_messages(diagnostics);
    const Bsdf bsdf = stack_of(std::get<Scene>(*file)).bsdf;
    if (const auto* sheet = std::get_if<PrincipledThinBsdf>(&bsdf)) {
      EXPECT_EQ(sheet->diff_trans.value, 0.5);
    } else {
      EXPECT_TRUE(std::get<PrincipledBsdf>(bsdf).roughness.texture.has_value());
    }
  }
}

TEST(GltfMaterials, SpecularGlossiness) {
  const GltfRead read = with_material(
      R"("extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[1,1,1,1],"specularFactor":[0.5,0.25,0.25],"glossinessFactor":0.75}})");
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  const auto b = std::get<GltfBsdf>(stack_of(*read.scene).bsdf);
  EXPECT_EQ(b.base_color.value, glm::dvec3(0.5));
  EXPECT_EQ(b.roughness.value, 0.25);
  EXPECT_EQ(b.metallic.value, 0.0);
  EXPECT_NEAR(b.specular_color.value.x * 0.04, 0.5, 1e-12);
}

TEST(GltfMaterials, ColoursAreSrgbAndEmissionIsStrong) {
  const GltfRead read = with_material(
      textured() +
      R"(,"emissiveFactor":[1,0.5,0],"emissiveTexture":{"index":0},"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":6}})");
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  const AreaEmitter* emitter = read.scene->emitter_of(read.scene->instances.at(0));
  ASSERT_NE(emitter, nullptr);
  EXPECT_EQ(emitter->radiance.value, glm::dvec3(6, 3, 0));
  const Texture& texture = read.scene->textures.at(*emitter->radiance.texture);
  EXPECT_EQ(std::get<BitmapTexture>(texture.source).color_space, ColorSpace::srgb);
  EXPECT_EQ(read.scene->bitmaps.size(), 1u);  // decoded once
}

TEST(GltfMaterials, AlphaCutsOrBlends) {
  const GltfRead blend = with_material(textured() + R"(,"alphaMode":"BLEND")");
  ASSERT_TRUE(blend.scene.has_value()) << blend.messages();
  const auto mask = std::get<MaskAdapter>(stack_of(*blend.scene).adapters.at(0));
  EXPECT_EQ(mask.opacity.channel, TextureChannel::alpha);
  const GltfRead cut = with_material(textured() + R"(,"alphaMode":"MASK","alphaCutoff":0.25)");
  ASSERT_TRUE(cut.scene.has_value()) << cut.messages();
  const auto holes = std::get<MaskAdapter>(stack_of(*cut.scene).adapters.at(0));
  EXPECT_EQ(holes.opacity.channel, TextureChannel::alpha);
  EXPECT_EQ(cut.scene->textures.at(*holes.opacity.texture).alpha_cutoff, 0.25);  // compared after interpolation
  const GltfRead opaque = with_material(textured());
  EXPECT_EQ(stack_of(opaque.scene.value()).adapters.size(), 1u);  // alpha means nothing
  EXPECT_FALSE(with_material(R"("alphaMode":"GLASS")").scene.has_value());
}

TEST(GltfMaterials, TexturesAreTurnedAndWrapped) {
  const GltfRead read = with_material(
      textured(
          R"(,"extensions":{"KHR_texture_transform":{"offset":[0.25,0.5],"rotation":1.5707963267948966,"scale":[2,4],"texCoord":1}})"),
      "", R"("source":0,"sampler":0}],"samplers":[{"wrapS":33071,"wrapT":33648,"magFilter":9728)");
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  const auto bsdf = std::get<GltfBsdf>(stack_of(*read.scene).bsdf);
  const Texture& texture = read.scene->textures.at(*bsdf.base_color.texture);
  EXPECT_EQ(texture.uv_set, 1u);
  const auto& source = std::get<BitmapTexture>(texture.source);
  EXPECT_EQ(source.wrap_u, TextureWrap::clamp);
  EXPECT_EQ(source.wrap_v, TextureWrap::mirror);
  EXPECT_EQ(source.filter, TextureFilter::nearest);
  // (u, v) downward = (0.5, 0.25): scaled (1, 1), turned by a quarter (1, −1), moved (1.25, −0.5).
  const glm::dvec3 moved = texture.uv_transform * glm::dvec3(0.5, 1.0 - 0.25, 1.0);
  EXPECT_NEAR(moved.x, 1.25, 1e-12);
  EXPECT_NEAR(1.0 - moved.y, -0.5, 1e-12);
}

TEST(GltfMaterials, MirroredCoordinatesTurnTheBitangent) {
  // Set 1 runs the other way round than set 0.
  for (const int set : {0, 1}) {
    const GltfRead read = with_material(fmt::format(R"("normalTexture":{{"index":0,"texCoord":{}}})", set));
    ASSERT_TRUE(read.scene.has_value()) << read.messages();
    const Stack stack = stack_of(*read.scene);
    const auto& normals = std::get<NormalMapAdapter>(stack.adapters.at(1));
    const auto& source = std::get<BitmapTexture>(read.scene->textures.at(*normals.normals.texture).source);
    const Bitmap& bitmap = *read.scene->bitmaps.at(source.bitmap);
    EXPECT_EQ(source.color_space, ColorSpace::linear);
    // As texture coordinates of the file run downward, those of a face seen upright are mirrored there and not here.
    EXPECT_FLOAT_EQ(bitmap.stored(1, 0, 1), set == 0 ? 1.0f - 128.0f / 255.0f : 128.0f / 255.0f) << set;
  }
}

TEST(GltfMaterials, ScaledNormals) {
  const std::vector<std::uint8_t> file = picture({255, 0, 255, 255, 0, 255, 200, 255});
  const Bitmap made = scaled_normals(0.5, false).make(decode_png_bitmap(std::as_bytes(std::span(file)), "p.png"));
  EXPECT_FLOAT_EQ(made.stored(0, 0, 0), 0.75f);
  EXPECT_FLOAT_EQ(made.stored(0, 0, 1), 0.25f);
  EXPECT_FLOAT_EQ(made.stored(0, 0, 2), 1.0f);
  EXPECT_FLOAT_EQ(made.stored(1, 0, 2), 200.0f / 255.0f);
}

TEST(GltfMaterials, UnlitSurfacesEmitTheirColour) {
  const GltfRead read = with_material(textured() + R"(,"extensions":{"KHR_materials_unlit":{}})");
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  EXPECT_EQ(std::get<DiffuseBsdf>(stack_of(*read.scene).bsdf).albedo.value, glm::dvec3(0.0));
  EXPECT_EQ(read.scene->emitter_of(read.scene->instances.at(0))->radiance.value, glm::dvec3(1.0));
}

TEST(GltfMaterials, ColoursOfVertices) {
  const GltfRead read = with_material(R"("pbrMetallicRoughness":{"baseColorFactor":[0.5,1,1,1]})", R"(,"COLOR_0":3)");
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  EXPECT_EQ(read.mesh().vertex_colors.at(1), glm::vec3(0.0f, 0.2f, 0.0f));
  const auto bsdf = std::get<GltfBsdf>(stack_of(*read.scene).bsdf);
  EXPECT_EQ(bsdf.base_color.value, glm::dvec3(0.5, 1, 1));
  EXPECT_TRUE(std::holds_alternative<AttributeTexture>(read.scene->textures.at(*bsdf.base_color.texture).source));
  const GltfRead both = with_material(textured(), R"(,"COLOR_0":3)");
  ASSERT_TRUE(both.scene.has_value()) << both.messages();
  const Texture& product = both.scene->textures.at(*std::get<GltfBsdf>(stack_of(*both.scene).bsdf).base_color.texture);
  EXPECT_TRUE(product.vertex_tint && std::holds_alternative<BitmapTexture>(product.source));
  EXPECT_EQ(both.mesh().vertex_colors.size(), 3u);
  const GltfRead white = with_material(textured(), R"(,"COLOR_0":5)");  // of every vertex
  EXPECT_TRUE(white.mesh().vertex_colors.empty()) << white.messages();
}

/// What is transparent does not glow.
TEST(GltfMaterials, EmissionIsAsTransparentAsItsSurface) {
  const auto radiance = [](const GltfRead& read) {
    EXPECT_TRUE(read.scene.has_value()) << read.messages();
    return read.scene->emitter_of(read.scene->instances.at(0))->radiance;
  };
  const std::string glow = R"(,"emissiveFactor":[1,1,1])";
  const GltfRead even =
      with_material(R"("alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.25]})" + glow);
  EXPECT_EQ(radiance(even).value, glm::dvec3(0.25));
  const GltfRead blend = with_material(textured() + R"(,"alphaMode":"BLEND")" + glow);
  const Texture& grey = blend.scene.value().textures.at(*radiance(blend).texture);
  EXPECT_EQ(blend.scene->bitmaps.at(std::get<BitmapTexture>(grey.source).bitmap)->stored(1, 0, 0), 51.0f / 255.0f);
  const GltfRead cut = with_material(textured() + R"(,"alphaMode":"MASK","alphaCutoff":0.25)" + glow);
  const Texture& white = cut.scene.value().textures.at(*radiance(cut).texture);
  EXPECT_TRUE(white.premultiplied);
  EXPECT_EQ(white.alpha_cutoff, 0.25);
  const GltfRead unlit = with_material(
      R"("alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorTexture":{"index":0},"baseColorFactor":[1,1,1,0.5]},)"
      R"("extensions":{"KHR_materials_unlit":{}})");
  EXPECT_EQ(radiance(unlit).value, glm::dvec3(0.5));
}

TEST(GltfMaterials, AlphaOfVertices) {
  const auto read_with = [&](const std::string& material) { return with_material(material, R"(,"COLOR_0":6)"); };
  const GltfRead opaque = read_with(textured());
  EXPECT_TRUE(opaque.mesh().vertex_alphas.empty());
  const GltfRead blend = read_with(
      R"("alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorTexture":{"index":0},"baseColorFactor":[1,1,1,0.5]})");
  ASSERT_TRUE(blend.scene.has_value()) << blend.messages();
  EXPECT_EQ(blend.mesh().vertex_alphas, (std::vector<float>{0.0f, 1.0f, 0.2f}));
  const auto mask = std::get<MaskAdapter>(stack_of(*blend.scene).adapters.at(0));
  EXPECT_EQ(mask.opacity.value, 0.5);
  EXPECT_EQ(mask.opacity.channel, TextureChannel::alpha);
  EXPECT_TRUE(blend.scene->textures.at(*mask.opacity.texture).vertex_tint);
  const GltfRead cut =
      read_with(R"("alphaMode":"MASK","alphaCutoff":0.25,"pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.5]})");
  ASSERT_TRUE(cut.scene.has_value()) << cut.messages();
  const auto opacity = std::get<MaskAdapter>(stack_of(*cut.scene).adapters.at(0)).opacity;
  EXPECT_EQ(opacity.value, 1.0);
  EXPECT_EQ(cut.scene->textures.at(*opacity.texture).alpha_cutoff, 0.5);
  const GltfRead unlit =
      read_with(R"("alphaMode":"BLEND",)" + textured() + R"(,"extensions":{"KHR_materials_unlit":{}})");
  ASSERT_TRUE(unlit.scene.has_value()) << unlit.messages();
  const AreaEmitter& emitter = *unlit.scene->emitter_of(unlit.scene->instances.at(0));
  const Texture& shine = unlit.scene->textures.at(*emitter.radiance.texture);
  EXPECT_TRUE(shine.vertex_tint && shine.premultiplied);
}

TEST(GltfMaterials, VariantsByName) {
  const std::string variants =
      R"("name":"first"},{"name":"second","emissiveFactor":[1,1,1]}],"extensions":{"KHR_materials_variants":{"variants":[{"name":"day"},{"name":"night"}]}},"asset2":[{"x":0)";
  const auto emits = [&](const std::string& variant) {
    GltfBuffer buffer;
    buffer.accessor(right_triangle(), "VEC3", 3);
    const GltfRead read = read_asset(
        glb(one_primitive(
                buffer,
                R"("attributes":{"POSITION":0},"material":0,"extensions":{"KHR_materials_variants":{"mappings":[{"material":1,"variants":[1]}]}})",
                R"(,"materials":[{)" + variants + "}]"),
            buffer.bytes()),
        {.variant = variant});
    return read.scene ? (read.scene->emitters.empty() ? "no" : "yes") : read.messages();
  };
  EXPECT_EQ(emits(""), "no");
  EXPECT_EQ(emits("day"), "no");
  EXPECT_EQ(emits("night"), "yes");
  EXPECT_NE(emits("dusk").find("--variant dusk"), std::string::npos);
}

TEST(GltfMaterials, PicturesThatAreNotRead) {
  const std::string ktx = "\xabKTX 20\xbb\r\n\x1a\n";
  const std::vector<std::uint8_t> file(ktx.begin(), ktx.end());
  const std::string texture = R"("extensions":{"KHR_texture_basisu":{"source":0}})";
  const GltfRead refused = with_material(textured(), "", texture, {}, file);
  EXPECT_FALSE(refused.scene.has_value());
  EXPECT_NE(refused.messages().find("KTX2 (Basis Universal, KHR_texture_basisu)"), std::string::npos)
      << refused.messages();
  const GltfRead shown = with_material(textured(), "", texture, {.approximate = true}, file);
  EXPECT_EQ(shown.scene.value().approximations.size(), 1u);
  EXPECT_NE(shown.messages().find("shown without it"), std::string::npos);
  EXPECT_FALSE(with_material(textured(), "", "").scene.has_value());
  EXPECT_FALSE(with_material(textured(R"(,"texCoord":-1)")).scene.has_value());
  EXPECT_TRUE(with_material(textured(R"(,"texCoord":7)")).scene.has_value());  // with a warning
}

}  // namespace
}  // namespace etendue::testing
