// Good scene files: what every word means, the defaults, transforms, overrides, hashes.

#include <clocale>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "formats/nori/plugins.h"
#include "formats_testing.h"
#include "scene/check.h"
#include "scene/placed.h"

namespace etendue::testing {
namespace {

void expect_near(const glm::dvec3& a, const glm::dvec3& b, double tolerance = 1e-12) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

Scene read_good(std::string_view text, const ReadOptions& options = {}) {
  Parsed parsed = parse(text, options);
  EXPECT_TRUE(parsed.file.has_value()) << all_messages(parsed.diagnostics);
  return parsed.scene();
}

const Bsdf& bsdf_of(const Scene& scene, std::size_t instance) {
  return scene.bsdf_of(scene.instances[instance]);
}
Sphere sphere_of(const Scene& scene, std::size_t instance) {
  return placed_sphere(std::get<Sphere>(scene.shape_of(scene.instances[instance])), scene.instances[instance]);
}
const TriangleMesh& mesh_of(const Scene& scene, std::size_t instance) {
  return std::get<TriangleMesh>(scene.shape_of(scene.instances[instance]));
}

glm::dmat4 transform(const std::string& operations) {
  return read_good("<scene><integrator type=\"path\"/><camera type=\"perspective\"><transform name=\"toWorld\">" +
                   operations + "</transform></camera></scene>")
      .camera.world_from_camera;
}

glm::dvec3 apply(const glm::dmat4& m, const glm::dvec3& p) {
  return glm::dvec3(m * glm::dvec4(p, 1.0));
}

TEST(SceneReader, EverythingThatCanBeSaid) {
  const Scene scene = read_good(R"(<?xml version="1.0" encoding="utf-8"?>
<!-- a comment with <tags> & things -->
<scene>
  <color name="sky_top" value="0.5,0.6,0.7"/> <color name="sky_horizon" value="1 2 3"/>
  <mesh type="obj">
    <string name="filename" value="  meshes/a b.obj  "/>
    <bsdf type="diffuse"><color name="albedo" value="0.1,	0.2,
       0.3"/></bsdf>
    <emitter type="area"><color name="radiance" value="+1 2e1 3.5"/></emitter>
    <transform name="toWorld"><translate value="1,2,3"/></transform>
  </mesh>
  <mesh type="sphere"><point name="center" value="1 2 3"/><float name="radius" value=" 2.5 "/>
    <bsdf type="dielectric"><float name="intIOR" value="1.33"/><float name="extIOR" value="1.1"/></bsdf></mesh>
  <mesh type="sphere"><bsdf type="mirror"/></mesh>
  <mesh type="sphere"/>
  <integrator type="path">
    <integer name="maxDepth" value="7"/><boolean name="nee" value="TRUE"/><boolean name="mis" value="False"/><integer name="rrDepth" value="0"/>
  </integrator>
  <sampler type="independent"><integer name="sampleCount" value="4294967295"/></sampler>
  <camera type="perspective">
    <integer name="width" value="640"/><integer name="height" value="+480"/><float name="fov" value="1e-6"/>
    <float name="nearClip" value="0"/><float name="farClip" value="100"/>
    <rfilter type="gaussian"><float name="radius" value="3"/><float name="stddev" value="0.7"/></rfilter>
  </camera>
</scene>
)");
  EXPECT_EQ(scene.name, "s");
  EXPECT_EQ(scene.file, "s.xml");
  expect_near(scene.sky.top, {0.5, 0.6, 0.7});
  expect_near(scene.sky.horizon, {1, 2, 3});
  ASSERT_EQ(scene.instances.size(), 4u);
  EXPECT_EQ(scene.instances[0].name, "a b.obj");
  EXPECT_EQ(scene.instances[0].position.line, 5);
  EXPECT_EQ(scene.instances[0].position.column, 3);
  expect_near(mesh_of(scene, 0).positions[1], {1, 0, 0});
  expect_near(PlacedMesh(mesh_of(scene, 0), scene.instances[0]).position(1), {2, 2, 3});
  expect_near(std::get<DiffuseBsdf>(bsdf_of(scene, 0)).albedo.value, {0.1, 0.2, 0.3});
  expect_near(scene.emitter_of(scene.instances[0])->radiance.value, {1, 20, 3.5});
  expect_near(sphere_of(scene, 1).center, {1, 2, 3});
  EXPECT_EQ(sphere_of(scene, 1).radius, 2.5);
  EXPECT_EQ(std::get<DielectricBsdf>(bsdf_of(scene, 1)).int_ior, 1.33);
  EXPECT_EQ(std::get<DielectricBsdf>(bsdf_of(scene, 1)).ext_ior, 1.1);
  EXPECT_TRUE(std::holds_alternative<MirrorBsdf>(bsdf_of(scene, 2)));
  expect_near(std::get<DiffuseBsdf>(bsdf_of(scene, 3)).albedo.value, glm::dvec3(0.5));
  EXPECT_FALSE(scene.instances[3].emitter.has_value());
  EXPECT_EQ(scene.integrator.type, Integrator::Type::path);
  EXPECT_EQ(scene.integrator.max_depth, 7u);
  EXPECT_TRUE(scene.integrator.nee);
  EXPECT_FALSE(scene.integrator.mis);
  EXPECT_EQ(scene.integrator.rr_depth, 0u);
  EXPECT_EQ(scene.sampler.sample_count, 4294967295u);
  EXPECT_EQ(scene.camera.width, 640u);
  EXPECT_EQ(scene.camera.height, 480u);
  EXPECT_EQ(scene.camera.fov, 1e-6);
  EXPECT_EQ(scene.camera.near_clip, 0.0);
  EXPECT_EQ(scene.camera.far_clip, 100.0);
  EXPECT_EQ(scene.camera.filter.type, ReconstructionFilter::Type::gaussian);
  EXPECT_EQ(scene.camera.filter.radius, 3.0);
  EXPECT_EQ(scene.camera.filter.stddev, 0.7);
}

TEST(SceneReader, DefaultsAreThoseOfTheStructs) {
  const Scene scene = read_good(scene_around(
      "<mesh type=\"sphere\"><bsdf type=\"diffuse\"/></mesh><mesh type=\"sphere\"><bsdf type=\"dielectric\"/></mesh>"));
  const Camera camera;
  EXPECT_EQ(scene.camera.width, 1280u);
  EXPECT_EQ(scene.camera.height, 720u);
  EXPECT_EQ(scene.camera.fov, 30.0);
  EXPECT_EQ(scene.camera.near_clip, camera.near_clip);
  EXPECT_EQ(scene.camera.far_clip, camera.far_clip);
  EXPECT_EQ(scene.camera.world_from_camera, glm::dmat4(1.0));
  EXPECT_EQ(scene.camera.filter.type, ReconstructionFilter::Type::gaussian);  // Nori's
  EXPECT_EQ(scene.sampler.sample_count, 1u);
  EXPECT_EQ(scene.integrator.max_depth, 16u);
  EXPECT_TRUE(scene.integrator.nee);
  EXPECT_TRUE(scene.integrator.mis);
  EXPECT_EQ(scene.integrator.rr_depth, 5u);
  EXPECT_EQ(scene.sky.top, glm::dvec3(0.0));
  EXPECT_EQ(scene.sky.horizon, glm::dvec3(0.0));
  EXPECT_EQ(std::get<DiffuseBsdf>(bsdf_of(scene, 0)).albedo.value, glm::dvec3(0.5));
  EXPECT_EQ(std::get<DielectricBsdf>(bsdf_of(scene, 1)).int_ior, 1.5046);
  EXPECT_EQ(std::get<DielectricBsdf>(bsdf_of(scene, 1)).ext_ior, 1.000277);
  EXPECT_EQ(sphere_of(scene, 0).radius, 1.0);
}

TEST(SceneReader, FiltersAndTheirDefaults) {
  using Type = ReconstructionFilter::Type;
  const std::pair<const char*, Type> filters[] = {{"box", Type::box},
                                                  {"tent", Type::tent},
                                                  {"gaussian", Type::gaussian},
                                                  {"mitchell", Type::mitchell},
                                                  {"lanczos", Type::lanczos}};
  for (const auto& [name, type] : filters) {
    const Scene scene = read_good(fmt::format(
        "<scene><integrator type=\"path\"/><camera type=\"perspective\"><rfilter type=\"{}\"/></camera></scene>",
        name));
    EXPECT_EQ(scene.camera.filter.type, type);
    EXPECT_EQ(scene.camera.filter.radius, 2.0);
    EXPECT_EQ(scene.camera.filter.stddev, 0.5);
    EXPECT_EQ(scene.camera.filter.b, 1.0 / 3.0);
    EXPECT_EQ(scene.camera.filter.c, 1.0 / 3.0);
    EXPECT_EQ(scene.camera.filter.stretch, 1.0);
    EXPECT_EQ(scene.camera.filter.lobes, 3u);
  }
}

Integrator integrator(const std::string& element, const std::string& scene_properties = "") {
  return read_good("<scene>" + scene_properties + element + "<camera type=\"perspective\"/></scene>").integrator;
}

TEST(SceneReader, IntegratorAliases) {
  const Integrator mats = integrator("<integrator type=\"path_mats\"/>");
  const Integrator ems = integrator("<integrator type=\"path_ems\"/>");
  const Integrator mis = integrator("<integrator type=\"path_mis\"/>");
  EXPECT_FALSE(mats.nee);
  EXPECT_TRUE(ems.nee);
  EXPECT_FALSE(ems.mis);
  EXPECT_TRUE(mis.nee);
  EXPECT_TRUE(mis.mis);
  for (const Integrator& i : {mats, ems, mis}) {
    EXPECT_EQ(i.type, Integrator::Type::path);
    EXPECT_EQ(i.max_depth, Integrator::kUnlimitedDepth);
    EXPECT_EQ(i.rr_depth, 5u);
  }
  EXPECT_EQ(integrator("<integrator type=\"normals\"/>").type, Integrator::Type::absolute_normals);
}

TEST(SceneReader, IntegratorsOfTheCourses) {
  using Type = Integrator::Type;
  const auto with = [](const char* type, const char* properties = "") {
    return integrator(fmt::format("<integrator type=\"{}\">{}</integrator>", type, properties));
  };
  EXPECT_EQ(with("normals", "<boolean name=\"signed\" value=\"true\"/>").type, Type::normals);
  EXPECT_EQ(with("depth").type, Type::depth);
  EXPECT_EQ(with("whitted").type, Type::whitted);
  EXPECT_EQ(with("ao").length, std::numeric_limits<double>::infinity());
  EXPECT_EQ(with("ao", "<float name=\"length\" value=\"2\"/>").length, 2.0);
  EXPECT_EQ(with("av", "<float name=\"length\" value=\"0.5\"/>").length, 0.5);
  const Integrator simple =
      with("simple", "<point name=\"position\" value=\"1 2 3\"/><color name=\"energy\" value=\"3e4 2e4 1e4\"/>");
  EXPECT_EQ(simple.light.position, glm::dvec3(1, 2, 3));
  EXPECT_EQ(simple.light.energy, glm::dvec3(3e4, 2e4, 1e4));
  const auto counts = [&](const char* type, const char* properties = "") {
    const Integrator i = with(type, properties);
    EXPECT_EQ(i.type, Type::direct);
    return std::pair(i.emitter_samples, i.bsdf_samples);
  };
  EXPECT_EQ(counts("direct"), std::pair(1u, 1u));
  EXPECT_EQ(counts("direct_ems"), std::pair(1u, 0u));
  EXPECT_EQ(counts("direct_mats"), std::pair(0u, 1u));
  EXPECT_EQ(counts("direct_mis"), std::pair(1u, 1u));
  EXPECT_EQ(
      counts("direct", "<integer name=\"emitterSamples\" value=\"4\"/><integer name=\"bsdfSamples\" value=\"0\"/>"),
      std::pair(4u, 0u));
  EXPECT_TRUE(with("whitted", "<boolean name=\"hideEmitters\" value=\"true\"/>").hide_emitters);
  EXPECT_TRUE(with("volpath").mis);
  EXPECT_FALSE(with("vol_path_mats").nee);
}

Camera camera(const char* type, const std::string& properties = "") {
  return read_good(
             fmt::format("<scene><integrator type=\"path\"/><camera type=\"{}\"><integer name=\"width\" value=\"200\"/>"
                         "<integer name=\"height\" value=\"100\"/>{}</camera></scene>",
                         type, properties))
      .camera;
}

TEST(SceneReader, Cameras) {
  using Type = Camera::Type;
  EXPECT_EQ(camera("orthographic").type, Type::orthographic);
  EXPECT_EQ(camera("spherical").type, Type::spherical);
  EXPECT_EQ(camera("radiancemeter").type, Type::radiance_meter);
  EXPECT_EQ(camera("irradiancemeter").type, Type::irradiance_meter);
  const Camera lens = camera("thinlens",
                             "<float name=\"apertureRadius\" value=\"0.2\"/><float name=\"focusDistance\" value=\"3\"/>"
                             "<integer name=\"blades\" value=\"6\"/><float name=\"bladeRotation\" value=\"15\"/>");
  EXPECT_EQ(lens.type, Type::thin_lens);
  EXPECT_EQ(lens.aperture.radius, 0.2);
  EXPECT_EQ(lens.aperture.focus_distance, 3.0);
  EXPECT_EQ(lens.aperture.blades, 6u);
  EXPECT_EQ(lens.aperture.rotation, 15.0);
  EXPECT_EQ(camera("perspective", "<string name=\"fovAxis\" value=\"smaller\"/>").fov_axis, Camera::FovAxis::smaller);
  const Camera film = camera("perspective", "<float name=\"focalLength\" value=\"50\"/>");
  EXPECT_EQ(film.fov_axis, Camera::FovAxis::diagonal);
  EXPECT_NEAR(film.fov, 46.79, 0.01);  // the usual figure for this lens
  const Camera crop = camera("perspective",
                             "<integer name=\"cropWidth\" value=\"50\"/><integer name=\"cropOffsetX\" value=\"100\"/>"
                             "<integer name=\"cropOffsetY\" value=\"25\"/>");
  EXPECT_EQ(crop.width, 50u);
  EXPECT_EQ(crop.height, 75u);
  EXPECT_EQ(crop.window.origin, glm::dvec2(0.5, 0.25));
  EXPECT_EQ(crop.window.size, glm::dvec2(0.25, 0.75));
  EXPECT_EQ(film_aspect(crop), 0.5);
}

TEST(SceneReader, CamerasKeepTheirHash) {
  const auto hash = [](const char* type, const std::string& properties = "") {
    Scene scene;
    scene.camera = camera(type, properties);
    return scene_hash(scene);
  };
  const std::uint64_t plain = hash("perspective");
  EXPECT_NE(plain, hash("orthographic"));
  EXPECT_NE(plain, hash("perspective", "<string name=\"fovAxis\" value=\"y\"/>"));
  EXPECT_NE(plain, hash("perspective", "<integer name=\"cropWidth\" value=\"50\"/>"));
  const auto lens = [&](const char* radius) {
    return hash("thinlens", fmt::format("<float name=\"apertureRadius\" value=\"{}\"/><float name=\"focusDistance\" "
                                        "value=\"3\"/>",
                                        radius));
  };
  EXPECT_NE(lens("0.1"), lens("0.2"));
}

TEST(SceneReader, TypesByOverride) {
  const std::string text =
      "<scene><integrator type=\"path\"><integer name=\"maxDepth\" value=\"7\"/></integrator>"
      "<camera type=\"perspective\"/></scene>";
  // What belongs to the replaced type is no mistake, even where mistakes are refused.
  EXPECT_EQ(read_good(text, {{{"integrator.type", "ao"}, {"integrator.length", "2"}}, true}).integrator.length, 2.0);
  EXPECT_EQ(read_good(text, {{{"integrator.type", "path_mats"}}, true}).integrator.max_depth, 7u);
  EXPECT_EQ(read_good(text, {{{"sampler.type", "sobol"}}, true}).sampler.type, Sampler::Type::sobol);
  // A type that nobody knows may be replaced, too.
  EXPECT_EQ(read_good("<scene><integrator type=\"radiosity\"><float name=\"x\" value=\"1\"/></integrator>"
                      "<camera type=\"perspective\"/></scene>",
                      {{{"integrator.type", "depth"}}, true})
                .integrator.type,
            Integrator::Type::depth);
  Diagnostics diagnostics;
  TemporaryFolder folder;
  EXPECT_FALSE(read_scene_file(folder.write("s.xml", text), {{{"integrator.type", "pth"}}, false}, diagnostics));
  EXPECT_NE(all_messages(diagnostics).find("unknown integrator type \"pth\"; did you mean \"path\"?"),
            std::string::npos)
      << all_messages(diagnostics);
}

TEST(SceneReader, NeeOfTheSceneYieldsToTheIntegrator) {
  const std::string off = "<boolean name=\"nee\" value=\"false\"/>", on = "<boolean name=\"nee\" value=\"true\"/>";
  EXPECT_FALSE(integrator("<integrator type=\"path\"/>", off).nee);
  EXPECT_TRUE(integrator("<integrator type=\"path\"/>", on).nee);
  EXPECT_TRUE(integrator("<integrator type=\"path\">" + on + "</integrator>", off).nee);
  EXPECT_FALSE(integrator("<integrator type=\"path_mats\"/>", on).nee);
}

TEST(SceneReader, TransformsApplyInTheOrderListed) {
  expect_near(apply(transform("<translate value=\"1 0 0\"/><scale value=\"2 3 4\"/>"), {1, 1, 1}), {4, 3, 4});
  expect_near(apply(transform("<scale value=\"2 3 4\"/><translate value=\"1 0 0\"/>"), {1, 1, 1}), {3, 3, 4});
  // Right-handed: a quarter turn about +Y takes +Z to +X. The axis need not have unit length.
  expect_near(apply(transform("<rotate angle=\"90\" axis=\"0 10 0\"/>"), {0, 0, 1}), {1, 0, 0});
  expect_near(apply(transform("<rotate angle=\"450\" axis=\"0 0 1e-200\"/>"), {1, 0, 0}), {0, 1, 0});
  expect_near(apply(transform("<matrix value=\"1,2,3,4, 0,1,0,5, 0,0,1,6, 0,0,0,1\"/>"), {1, 1, 1}), {10, 6, 7});
}

TEST(SceneReader, LookatFrame) {
  const glm::dmat4 m = transform("<lookat origin=\"1 2 3\" target=\"1 2 13\" up=\"0 5 0\"/>");
  expect_near(glm::dvec3(m[0]), {1, 0, 0});  // left = up × dir
  expect_near(glm::dvec3(m[1]), {0, 1, 0});
  expect_near(glm::dvec3(m[2]), {0, 0, 1});
  expect_near(glm::dvec3(m[3]), {1, 2, 3});
  const glm::dmat4 oblique = transform("<lookat origin=\"1 1 1\" target=\"0 0 0\" up=\"0 1 0\"/>");
  const glm::dvec3 dir = glm::normalize(glm::dvec3(-1.0));
  expect_near(glm::dvec3(oblique[2]), dir);
  EXPECT_NEAR(glm::dot(glm::dvec3(oblique[0]), dir), 0.0, 1e-15);
  EXPECT_GT(oblique[1][1], 0.0);
  EXPECT_NEAR(glm::determinant(glm::dmat3(oblique)), 1.0, 1e-12);
}

TEST(SceneReader, LookatMeasuresWhatNoSquareHolds) {
  const glm::dmat4 plain = transform("<lookat origin=\"1 2 3\" target=\"1 2 13\" up=\"0 5 0\"/>");
  for (const char* up : {"0 1e200 0", "0 1e-200 0", "0 1e308 0", "0 5e-324 0"})
    EXPECT_EQ(transform("<lookat origin=\"1 2 3\" target=\"1 2 13\" up=\"" + std::string(up) + "\"/>"), plain) << up;
  EXPECT_EQ(transform("<lookat origin=\"0 0 0\" target=\"0 0 1e-200\" up=\"0 1 0\"/>")[2], glm::dvec4(0, 0, 1, 0));
}

TEST(SceneReader, LookatAlongItsUpTakesAnotherAndWarns) {
  struct Case {
    const char *target, *up, *says;
    glm::dvec3 expected_up;
  };
  // The axis across the view where it has most room: y, then z, then x.
  for (const Case& c : {Case{"0 1 0", "0 1 0", "0 0 1", {0, 0, 1}}, Case{"0 -3 0", "0 2 0", "0 0 1", {0, 0, 1}},
                        Case{"0 0 -1", "0 0 1", "0 1 0", {0, 1, 0}}, Case{"9 0 0", "-1 0 0", "0 1 0", {0, 1, 0}},
                        Case{"1 2 3", "1 2 3", "1 0 0", glm::dvec3(13, -2, -3)}}) {
    const Parsed parsed = parse(
        "<scene><integrator type=\"path\"/><camera type=\"perspective\">\n<transform name=\"toWorld\">\n<lookat "
        "origin=\"0 0 0\" target=\"" +
        std::string(c.target) + "\" up=\"" + c.up + "\"/></transform></camera></scene>");
    ASSERT_TRUE(parsed.file.has_value()) << all_messages(parsed.diagnostics);
    const glm::dmat4 m = parsed.scene().camera.world_from_camera;
    expect_near(glm::dvec3(m[1]), glm::normalize(c.expected_up));
    EXPECT_NEAR(glm::determinant(glm::dmat3(m)), 1.0, 1e-12);
    const Diagnostic& warning = parsed.diagnostics.list().front();
    EXPECT_EQ(warning.severity, Severity::warning);
    EXPECT_EQ(warning.position.line, 3);
    EXPECT_NE(warning.message.find(std::string("parallel to the direction of view; ") + c.says + " is taken instead"),
              std::string::npos)
        << warning.message;
  }
}

TEST(SceneReader, NoTurnNeedsNoAxis) {
  for (const char* operation : {"<rotate angle=\"0\" axis=\"0 0 0\"/>", "<rotate angle=\"-0.0\" axis=\"0 0 0\"/>",
                                "<rotate angle=\"360\" axis=\"0 0 0\"/>", "<rotate angle=\"0\" axis=\"3 0 0\"/>"})
    EXPECT_EQ(transform(operation), glm::dmat4(1.0)) << operation;
}

TEST(SceneReader, NumbersInAllSpellingsEverywhere) {
  const std::string numbers[] = {"3.1e+2", "310.", "+310", "+3.1E2", " 310 ", "0310", ".31e3"};
  const std::string fractions[] = {".5", "+.5", "5e-1", "5.e-1", "+0.50", "50E-2", "0.5"};
  for (std::size_t i = 0; i < std::size(numbers); ++i) {
    const std::string &n = numbers[i], &f = fractions[i];
    const Scene scene = read_good(
        "<scene><integrator type=\"path\"><integer name=\"maxDepth\" value=\"" + n +
            "\"/></integrator><camera type=\"perspective\"><integer name=\"width\" value=\"" + n +
            "\"/><float name=\"nearClip\" value=\"" + f + "\"/><transform name=\"toWorld\"><translate value=\"" + n +
            "," + f + "," + n + "\"/><rotate angle=\"" + n + "\" axis=\"0 " + f +
            " 0\"/><rotate angle=\"-310\" axis=\"0 1 0\"/></transform>" + "</camera><color name=\"sky_top\" value=\"" +
            f + " " + f + "," + n + "\"/></scene>",
        {{{"sampler.sampleCount", n}}, false});
    EXPECT_EQ(scene.integrator.max_depth, 310u) << n;
    EXPECT_EQ(scene.camera.width, 310u) << n;
    EXPECT_EQ(scene.camera.near_clip, 0.5) << f;
    EXPECT_EQ(scene.sampler.sample_count, 310u) << n;
    EXPECT_EQ(scene.sky.top, glm::dvec3(0.5, 0.5, 310.0)) << n << " " << f;
    expect_near(glm::dvec3(scene.camera.world_from_camera[3]) / 310.0, glm::dvec3(310.0, 0.5, 310.0) / 310.0);
  }
}

TEST(SceneReader, MirroredLookat) {
  const glm::dmat4 plain = transform("<lookat origin=\"0 1 5\" target=\"0 1 0\" up=\"0 1 0\"/>");
  const glm::dmat4 mirrored =
      transform("<scale value=\"-1,1,1\"/><lookat origin=\"0 1 5\" target=\"0 1 0\" up=\"0 1 0\"/>");
  EXPECT_LT(glm::determinant(glm::dmat3(mirrored)), 0.0);
  expect_near(glm::dvec3(mirrored[0]), -glm::dvec3(plain[0]));
  expect_near(glm::dvec3(mirrored[2]), glm::dvec3(plain[2]));
  expect_near(glm::dvec3(mirrored[3]), glm::dvec3(plain[3]));
}

TEST(SceneReader, TinyAndHugeScalesAreFine) {
  expect_near(apply(transform("<scale value=\"1e-3 1e-3 1e-3\"/>"), {1, 1, 1}), glm::dvec3(1e-3));
  expect_near(apply(transform("<scale value=\"1e-30 1e-30 1e-30\"/><scale value=\"1e30 1e30 1e30\"/>"), {1, 1, 1}),
              glm::dvec3(1.0));
}

TEST(SceneReader, Overrides) {
  const std::string text =
      scene_around("<sampler type=\"independent\"><integer name=\"sampleCount\" value=\"4\"/></sampler>");
  const Scene scene = read_good(text, {{{"integrator.nee", "false"},
                                        {"sampler.sampleCount", "64"},
                                        {"camera.width", "400"},
                                        {"camera.width", "200"},
                                        {"scene.sky_top", "1 1 1"}},
                                       false});
  EXPECT_FALSE(scene.integrator.nee);
  EXPECT_EQ(scene.sampler.sample_count, 64u);
  EXPECT_EQ(scene.camera.width, 200u) << "the last one counts";
  EXPECT_EQ(scene.sky.top, glm::dvec3(1.0));
  // Also what the file leaves out.
  EXPECT_EQ(read_good(scene_around(""), {{{"sampler.sampleCount", "9"}}, false}).sampler.sample_count, 9u);
}

TEST(SceneReader, SobolSamplers) {
  const Scene plain = read_good(scene_around("<sampler type=\"sobol\"/>"));
  EXPECT_EQ(plain.sampler.type, Sampler::Type::sobol);
  EXPECT_EQ(plain.sampler.set_size(), 16u);
  const Scene other =
      read_good(scene_around("<sampler type=\"sobol\"><integer name=\"setSize\" value=\"64\"/>"
                             "<integer name=\"sampleCount\" value=\"100\"/></sampler>"));
  EXPECT_EQ(other.sampler.set_bits, 6u);
  EXPECT_EQ(other.sampler.sets_of(other.sampler.sample_count), 2u);
  // Samples of another kind of set must never be merged with these; those of independent numbers are what they were.
  const Scene independent = read_good(scene_around(""));
  EXPECT_NE(scene_hash(plain), scene_hash(other));
  EXPECT_NE(scene_hash(plain), scene_hash(independent));
  EXPECT_EQ(independent.sampler.set_size(), 1u);
  EXPECT_EQ(independent.sampler.sets_of(7), 7u);
}

TEST(SceneReader, OverridesThatMatchNothing) {
  for (const auto& [name, expected] : {std::pair{"camera.widht", "did you mean \"camera.width\"?"},
                                       std::pair{"rfilter.B", "known here are: camera.apertureRadius"},
                                       std::pair{"camera.toWorld", "has no property \"camera.toWorld\""}}) {
    const Parsed parsed = parse(scene_around(""), {{{name, "3"}}, false});
    EXPECT_FALSE(parsed.file.has_value());
    ASSERT_EQ(parsed.diagnostics.list().size(), 1u);
    EXPECT_NE(to_string(parsed.diagnostics.list()[0]).find(expected), std::string::npos)
        << all_messages(parsed.diagnostics);
    EXPECT_EQ(parsed.diagnostics.list()[0].kind, ErrorKind::usage);
  }
  const Parsed bad = parse(scene_around(""), {{{"camera.width", "0"}}, false});
  ASSERT_TRUE(bad.diagnostics.has_errors());
  EXPECT_EQ(to_string(bad.diagnostics.list()[0]), "-D camera.width=0: 0 is out of range; allowed is 1 … 65536");
}

TEST(SceneReader, OverridesReachEverySceneOfATest) {
  const Parsed parsed = parse("<test type=\"ttest\"><string name=\"references\" value=\"1 2\"/>" + scene_around("") +
                                  scene_around("") + "</test>",
                              {{{"integrator.maxDepth", "3"}, {"test.sampleCount", "500"}}, false});
  ASSERT_TRUE(parsed.file.has_value()) << all_messages(parsed.diagnostics);
  const auto& test = std::get<TTest>(*parsed.file);
  EXPECT_EQ(test.sample_count, 500u);
  ASSERT_EQ(test.scenes.size(), 2u);
  EXPECT_EQ(test.scenes[0].integrator.max_depth, 3u);
  EXPECT_EQ(test.scenes[1].integrator.max_depth, 3u);
  EXPECT_EQ(test.scenes[0].name, "s[1]");
  EXPECT_EQ(test.scenes[1].name, "s[2]");
  EXPECT_EQ(test.references, (std::vector<double>{1, 2}));
  EXPECT_EQ(test.significance_level, 0.01);
}

TEST(SceneReader, BsdfTests) {
  const Parsed t = parse(
      "<test type=\"ttest\"><string name=\"angles\" value=\"0,30,120\"/><string name=\"references\" value=\"1 2 3 4 5 "
      "6\"/>"
      "<bsdf type=\"diffuse\"/><bsdf type=\"mirror\"/></test>");
  ASSERT_TRUE(t.file.has_value()) << all_messages(t.diagnostics);
  const auto& ttest = std::get<TTest>(*t.file);
  EXPECT_EQ(ttest.angles, (std::vector<double>{0, 30, 120}));
  ASSERT_EQ(ttest.bsdfs.size(), 2u);
  EXPECT_EQ(ttest.bsdfs[1].name, "mirror 2");
  EXPECT_EQ(ttest.sample_count, 100000u);
  const Parsed c = parse("<test type=\"chi2test\"><bsdf type=\"dielectric\"/></test>");
  ASSERT_TRUE(c.file.has_value()) << all_messages(c.diagnostics);
  const auto& chi2 = std::get<Chi2Test>(*c.file);
  EXPECT_EQ(chi2.significance_level, 0.01);
  EXPECT_EQ(chi2.resolution, 10u);
  EXPECT_EQ(chi2.min_exp_frequency, 5.0);
  EXPECT_EQ(chi2.sample_count, 0u);
  EXPECT_EQ(chi2.test_count, 5u);
  EXPECT_EQ(chi2.bsdfs.size(), 1u);
}

TEST(SceneReader, EveryRowOfTheTableCanBeUsedWithItsDefaults) {
  const Dialect& dialect = nori_dialect();
  for (const Plugin& plugin : dialect.plugins) {
    for (const Parameter& parameter : plugin.parameters) {
      const bool has_text = parameter.default_text != nullptr && *parameter.default_text != '\0';
      if (!has_text || parameter.type == ParameterType::transform) continue;
      EXPECT_NO_THROW(parse_value(parameter.type, parameter.range, parameter.default_text))
          << plugin.type << " " << parameter.name;
    }
    if (std::string_view(plugin.tag) == "scene") continue;
    EXPECT_EQ(dialect.find(plugin.tag, plugin.type), &plugin) << "two rows for " << plugin.type;
    EXPECT_FALSE(dialect.is_known_but_unsupported(plugin.tag, plugin.type)) << plugin.type;
  }
}

TEST(SceneReader, ReferencesInAttributes) {
  const Scene scene =
      read_good(scene_around("<mesh type='obj'><string name='filename' value='a&amp;b&#x20ac;&#65;.obj'/></mesh>"));
  EXPECT_EQ(scene.instances[0].name, "a&b€A.obj");
}

TEST(SceneReader, NumbersDoNotDependOnTheLocale) {
  const char* before = std::setlocale(LC_ALL, nullptr);
  const std::string saved = before != nullptr ? before : "C";
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8"}) {
    if (std::setlocale(LC_ALL, name) == nullptr) continue;
    EXPECT_EQ(
        sphere_of(read_good(scene_around("<mesh type=\"sphere\"><float name=\"radius\" value=\"2.5\"/></mesh>")), 0)
            .radius,
        2.5);
  }
  std::setlocale(LC_ALL, saved.c_str());
}

TEST(SceneReader, FilesOutsideTheFolderAreNoted) {
  TemporaryFolder folder;
  const std::string mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  folder.write("outside.obj", mesh);
  folder.write("scenes/inside.obj", mesh);
  const auto mesh_element = [](const std::string& name) {
    return "<mesh type=\"obj\"><string name=\"filename\" value=\"" + name + "\"/></mesh>";
  };
  const std::string file =
      folder.write("scenes/s.xml", scene_around(mesh_element("inside.obj") + "\n" + mesh_element("sub/../inside.obj") +
                                                "\n" + mesh_element("../outside.obj")));
  Diagnostics diagnostics;
  folder.write("scenes/sub/x", "");
  ASSERT_TRUE(read_scene_file(file, {}, diagnostics).has_value()) << all_messages(diagnostics);
  ASSERT_EQ(diagnostics.list().size(), 1u) << all_messages(diagnostics);
  EXPECT_EQ(diagnostics.list()[0].severity, Severity::note);
  EXPECT_EQ(diagnostics.list()[0].position.line, 4);
}

TEST(SceneReader, FoldersAreComparedAlsoForRelativePaths) {
  TemporaryFolder folder;
  folder.write("s.xml", scene_around("<mesh type=\"obj\"><string name=\"filename\" value=\"none.obj\"/></mesh>"));
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path(""));
  Diagnostics diagnostics;
  read_scene_file("s.xml", {}, diagnostics);
  std::filesystem::current_path(before);
  ASSERT_EQ(diagnostics.list().size(), 1u) << all_messages(diagnostics);
  EXPECT_EQ(to_string(diagnostics.list()[0]),
            "s.xml:2:49: mesh none.obj: cannot open the file: No such file or directory; names are relative to the "
            "folder of the scene file");
}

TEST(SceneHash, ChangesWithEverythingThatChangesTheImage) {
  const auto text = [](const char* albedo, const char* radiance, const char* ior, const char* radius, const char* fov,
                       const char* sky, const char* translate, const char* filter) {
    return fmt::format(
        "<scene><integrator type=\"path\"/><color name=\"sky_top\" value=\"{}\"/><camera type=\"perspective\"><float "
        "name=\"fov\" value=\"{}\"/>"
        "<rfilter type=\"{}\"/></camera><mesh type=\"obj\"><string name=\"filename\" value=\"a.obj\"/><transform "
        "name=\"toWorld\">"
        "<translate value=\"{}\"/></transform><bsdf type=\"diffuse\"><color name=\"albedo\" "
        "value=\"{}\"/></bsdf><emitter type=\"area\">"
        "<color name=\"radiance\" value=\"{}\"/></emitter></mesh><mesh type=\"sphere\"><float name=\"radius\" "
        "value=\"{}\"/>"
        "<bsdf type=\"dielectric\"><float name=\"intIOR\" value=\"{}\"/></bsdf></mesh></scene>",
        sky, fov, filter, translate, albedo, radiance, radius, ior);
  };
  const std::string variants[] = {text("1 0 0", "1 1 1", "1.5", "1", "30", "0 0 0", "0 0 0", "box"),
                                  text("0 1 0", "1 1 1", "1.5", "1", "30", "0 0 0", "0 0 0", "box"),
                                  text("1 0 0", "1 1 2", "1.5", "1", "30", "0 0 0", "0 0 0", "box"),
                                  text("1 0 0", "1 1 1", "1.6", "1", "30", "0 0 0", "0 0 0", "box"),
                                  text("1 0 0", "1 1 1", "1.5", "2", "30", "0 0 0", "0 0 0", "box"),
                                  text("1 0 0", "1 1 1", "1.5", "1", "31", "0 0 0", "0 0 0", "box"),
                                  text("1 0 0", "1 1 1", "1.5", "1", "30", "0 0 1", "0 0 0", "box"),
                                  text("1 0 0", "1 1 1", "1.5", "1", "30", "0 0 0", "0 0 1", "box"),
                                  text("1 0 0", "1 1 1", "1.5", "1", "30", "0 0 0", "0 0 0", "tent")};
  std::set<std::uint64_t> hashes;
  for (const std::string& variant : variants) hashes.insert(scene_hash(read_good(variant)));
  EXPECT_EQ(hashes.size(), std::size(variants));
  EXPECT_EQ(scene_hash(read_good(variants[0])), scene_hash(read_good("<!-- other bytes -->" + variants[0])))
      << "not the file's bytes";
}

TEST(SceneHash, DoesNotDependOnSizeSamplesOrIntegrator) {
  const std::string text = scene_around("<mesh type=\"sphere\"/>");
  const std::uint64_t hash = scene_hash(read_good(text));
  for (const std::pair<std::string, std::string>& change : {std::pair<std::string, std::string>{"camera.width", "3"},
                                                            {"camera.height", "3"},
                                                            {"sampler.sampleCount", "3"},
                                                            {"integrator.maxDepth", "3"},
                                                            {"integrator.nee", "false"}}) {
    EXPECT_EQ(scene_hash(read_good(text, {{change}, false})), hash) << change.first;
  }
}

TEST(SceneHash, OrderOfShapesCounts) {
  const std::string a = "<mesh type=\"sphere\"/>",
                    b = "<mesh type=\"sphere\"><float name=\"radius\" value=\"2\"/></mesh>";
  EXPECT_NE(scene_hash(read_good(scene_around(a + b))), scene_hash(read_good(scene_around(b + a))));
}

TEST(FilmExponent, IsTheSmallestPowerOfTwoAbove) {
  const auto exponent = [](const std::string& radiance) {
    return film_exponent(
        read_good(scene_around("<mesh type=\"sphere\"><emitter type=\"area\"><color name=\"radiance\" value=\"" +
                               radiance + "\"/></emitter></mesh>")));
  };
  EXPECT_EQ(exponent("1 0 0"), 0);
  EXPECT_EQ(exponent("1 1.0000001 0"), 1);
  EXPECT_EQ(exponent("40 40 40"), 6);
  EXPECT_EQ(exponent("0 0 64"), 6);
  EXPECT_EQ(exponent("0.25 0 0"), -2);
  EXPECT_EQ(exponent("0.26 0 0"), -1);
  EXPECT_EQ(exponent("0 0 0"), 0);
  EXPECT_EQ(film_exponent(read_good(scene_around("<color name=\"sky_horizon\" value=\"0 3 0\"/>"))), 2);
  EXPECT_EQ(film_exponent(read_good("<scene><integrator type=\"normals\"/><camera type=\"perspective\"/><color "
                                    "name=\"sky_top\" value=\"9 9 9\"/></scene>")),
            0);
}

TEST(EveryShippedScene, ReadsWithoutAWarning) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(SCENES_DIR)) {
    if (entry.path().extension() != ".xml") continue;
    Diagnostics diagnostics;
    const auto file = read_scene_file(entry.path().string(), {{}, true}, diagnostics);
    // Large meshes are made by the build's target `scenes`, which need not have run.
    const std::string messages = all_messages(diagnostics);
    if (messages.find("--target scenes") != std::string::npos) continue;
    ASSERT_TRUE(file.has_value()) << messages;
    check_scene_file(*file, diagnostics);
    for (const Diagnostic& finding : diagnostics.list()) {
      EXPECT_EQ(finding.severity, Severity::note) << to_string(finding);
      EXPECT_NE(finding.message.find("\"etendue:"), std::string::npos) << to_string(finding);
    }
    ++count;
  }
  EXPECT_GE(count, 3);
}

TEST(SceneReader, WordsOfCourses) {
  const Parsed parsed = parse(
      "<scene><integrator type=\"path\"/><camera type=\"thin_lens\"><float name=\"lensRadius\" value=\"0.5\"/><float "
      "name=\"focalDistance\" "
      "value=\"3\"/></camera><sampler type=\"halton\"><integer name=\"sampleCount\" value=\"7\"/></sampler>"
      "<shape type=\"sphere\"><bsdf type=\"lambertian\"><color name=\"reflectance\" value=\"0.1 0.2 "
      "0.3\"/></bsdf></shape></scene>",
      {});
  ASSERT_TRUE(parsed.file.has_value()) << all_messages(parsed.diagnostics);
  const Scene& scene = std::get<Scene>(*parsed.file);
  EXPECT_EQ(scene.camera.aperture.radius, 0.5);
  EXPECT_EQ(scene.camera.aperture.focus_distance, 3.0);
  EXPECT_EQ(scene.sampler.type, Sampler::Type::sobol);
  EXPECT_EQ(std::get<DiffuseBsdf>(scene.materials.at(0).bsdf).albedo.value, glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_NE(all_messages(parsed.diagnostics).find("the sampler halton is read as sobol"), std::string::npos);
}

}  // namespace
}  // namespace etendue::testing
