// A dialect is a value: named children, ids and references, aliases, and what is said where they are wrong.

#include <fmt/format.h>
#include "formats/dialect/mesh_facts.h"
#include "formats/dialect/object.h"

#include "formats_testing.h"

namespace etendue::testing {
namespace {

using enum ParameterType;

/// As small as shows everything: a coat over a base, whose color may be a picture.
const Dialect& toy_dialect() {
  static const Dialect kDialect = {
      .plugins = {{"scene",
                   "",
                   "",
                   {},
                   {{"skin", 0, kAnyNumber},
                    {"picture", 0, kAnyNumber, ChildUse::definition},
                    {"coat", 0, kAnyNumber, ChildUse::definition}}},
                  {"skin", "plain", "", {{"tint", color, "0.5 0.5 0.5", {0, 1}, "", "picture"}}, {{"coat", 0, 1}}},
                  {"skin",
                   "layered",
                   "",
                   {{"base", object, nullptr, {}, "", "skin"}, {"top", object, "", {}, "", "skin"}},
                   {}},
                  {"coat", "clear", "", {}, {{"coat", 0, 1}}},
                  {"picture", "checker", "", {{"size", real, "1", {}, ""}}, {}}},
      .unsupported_types = {{"picture", {"photo"}}},
      .unsupported_tags = {"medium"},
      .aliases = {{"hide", "skin"}},
      .mesh_facts = {}};
  return kDialect;
}

/// Reads the root's children of a tag, and theirs, as a reader would.
struct Toy {
  explicit Toy(std::string text, bool strict = false)
      : document(std::move(text), "t.xml", diagnostics),
        references(document, toy_dialect(), diagnostics),
        context{toy_dialect(), document, references, diagnostics, overrides, strict, {}, {}} {
    if (diagnostics.has_errors() || !document.root()) return;
    if (const auto root = Object::read(*document.root(), context)) read_children(*root);
  }
  void read_children(const Object& object) {
    for (const char* tag : {"skin", "coat", "picture"}) {
      for (const XmlElement* element : object.children(tag)) read(*element);
    }
    for (const Parameter& parameter : object.plugin().parameters) {
      if (const XmlElement* element = object.child_of(parameter.name)) read(*element);
    }
  }
  void read(const XmlElement& element) {
    if (auto object = Object::read(element, context)) {
      read_children(*object);
      objects.push_back(std::move(*object));
    }
  }
  std::string messages() const { return all_messages(diagnostics); }

  Diagnostics diagnostics;
  XmlDocument document;
  References references;
  Overrides overrides;
  ReadContext context;
  std::vector<Object> objects;  ///< children before their parents
};

std::string line_of(int count, const char* text) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

TEST(Dialect, AnObjectStandsForAValue) {
  const Toy toy(
      "<scene><skin type='plain'><picture name='tint' type='checker'><float name='size' value='3'/></picture>"
      "</skin></scene>");
  ASSERT_EQ(toy.messages(), "");
  ASSERT_EQ(toy.objects.size(), 2u);
  EXPECT_EQ(toy.objects[0].get<double>("size"), 3.0);
  const Object& skin = toy.objects[1];
  ASSERT_NE(skin.child_of("tint"), nullptr);
  EXPECT_TRUE(skin.given("tint"));
  EXPECT_EQ(skin.position_of("tint").column, 27);
  EXPECT_EQ(skin.get<glm::dvec3>("tint"), glm::dvec3(0.5)) << "the default, as no value is given";
}

TEST(Dialect, AValueIsStillAValue) {
  const Toy toy("<scene><skin type='plain'><color name='tint' value='0 1 0'/></skin></scene>");
  ASSERT_EQ(toy.messages(), "");
  EXPECT_EQ(toy.objects.at(0).child_of("tint"), nullptr);
  EXPECT_EQ(toy.objects.at(0).get<glm::dvec3>("tint"), glm::dvec3(0, 1, 0));
}

TEST(Dialect, ReferencesReachWhatStandsBeforeAndAfter) {
  const Toy toy(
      "<scene><picture type='checker' id='a'/><skin type='plain'><ref name='tint' id='a'/><ref id='c'/></skin>"
      "<skin type='plain'><ref id='b' name='tint'/></skin><picture type='checker' id='b'/>"
      "<coat type='clear' id='c'/></scene>");
  ASSERT_EQ(toy.messages(), "");
  std::vector<const XmlElement*> tints;
  for (const Object& object : toy.objects) {
    if (std::string_view(object.plugin().tag) != "skin") continue;
    tints.push_back(object.child_of("tint"));
  }
  ASSERT_EQ(tints.size(), 2u);
  EXPECT_EQ(tints[0], toy.references.find("a"));
  EXPECT_EQ(tints[1], toy.references.find("b"));
  EXPECT_TRUE(toy.references.is_used("c"));
  EXPECT_FALSE(toy.references.is_used("d"));
}

TEST(Dialect, ObjectsNestByName) {
  const Toy toy(
      "<scene><skin type='layered'><skin name='base' type='layered'><skin type='plain' name='base'/></skin>"
      "<ref name='top' id='s'/></skin><skin type='plain' id='s'/></scene>");
  ASSERT_EQ(toy.messages(), "");
  EXPECT_EQ(toy.objects.size(), 5u) << "what is referred to is the child of both";
}

TEST(Dialect, AnAliasIsTheTagAndMessagesUseItsWord) {
  const Toy toy("<scene><hide type='plain'><color name='tone' value='1 1 1'/></hide></scene>", true);
  EXPECT_EQ(toy.messages(), "t.xml:1:40: <hide type=\"plain\"> has no property \"tone\"; it has: tint\n");
  EXPECT_EQ(toy.objects.size(), 1u);
}

struct BadToy {
  const char* what;
  const char* text;
  int column;
  const char* says;
};
void PrintTo(const BadToy& bad, std::ostream* out) {
  *out << bad.what;
}
class BadReference : public ::testing::TestWithParam<BadToy> {};

TEST_P(BadReference, IsRefusedAtItsPlace) {
  const BadToy& bad = GetParam();
  const Toy toy("<scene>\n" + std::string(bad.text) + "\n</scene>");
  ASSERT_EQ(toy.diagnostics.error_count(), 1u) << toy.messages();
  const Diagnostic& first = toy.diagnostics.list()[0];
  EXPECT_EQ(first.position.line, 2);
  EXPECT_EQ(first.position.column, bad.column) << toy.messages();
  EXPECT_EQ(first.message, bad.says);
}

const BadToy kBad[] = {
    {"UnknownId", "<picture type='checker' id='wood'/><skin type='plain'><ref name='tint' id='wod'/></skin>", 76,
     "nothing in this file has the id \"wod\"; did you mean \"wood\"?; there are: \"wood\""},
    {"NoIds", "<skin type='plain'><ref name='tint' id='wod'/></skin>", 41,
     "nothing in this file has the id \"wod\"; no object has one"},
    {"NoId", "<skin type='plain'><ref name='tint'/></skin>", 20,
     "<ref> lacks its attribute \"id\"; it takes: id, name"},
    {"Value", "<skin type='plain'><ref name='tint' id='a' value='1'/></skin>", 44,
     "<ref> has no attribute \"value\"; it takes: id, name"},
    {"EmptyId", "<picture type='checker' id=''/>", 29, "the id of this <picture> is empty; give it a name or none"},
    {"TwiceId", "<picture type='checker' id='a'/><coat type='clear' id='a'/>", 56,
     "the id \"a\" is given twice, first to the <picture> in line 2; rename one"},
    {"WrongClass", "<coat type='clear' id='a'/><skin type='plain'><ref name='tint' id='a'/></skin>", 47,
     "property \"tint\" of <skin type=\"plain\"> takes <color> or <picture>, but this refers to a <coat>"},
    {"WrongObject", "<skin type='plain'><skin type='plain' name='tint'/></skin>", 20,
     "property \"tint\" of <skin type=\"plain\"> takes <color> or <picture>, not <skin>"},
    {"WrongValue", "<skin type='plain'><float name='tint' value='1'/></skin>", 20,
     "property \"tint\" of <skin type=\"plain\"> is of type color, not float; write <color name=\"tint\" …>"},
    {"ValueForObject", "<skin type='layered'><float name='base' value='1'/></skin>", 22,
     "property \"base\" of <skin type=\"layered\"> takes <skin>, not a value"},
    {"MissingObject", "<skin type='layered'/>", 1,
     "<skin type=\"layered\"> needs its property \"base\"; add <skin name=\"base\" …/>"},
    {"Nameless", "<skin type='plain'><picture type='checker'/></skin>", 20,
     "<picture> inside <skin type=\"plain\"> needs the name of a property: \"tint\""},
    {"NamelessReference", "<picture type='checker' id='a'/><skin type='plain'><ref id='a'/></skin>", 52,
     "<ref id=\"a\"/>, which is a <picture>, inside <skin type=\"plain\"> needs the name of a property: \"tint\""},
    {"OutOfPlace", "<coat type='clear' id='a'/><skin type='plain'><ref id='a'/><ref id='a'/></skin>", 60,
     "<skin type=\"plain\"> has more than one <coat>; keep one"},
    {"Nowhere", "<skin type='plain' id='a'/><coat type='clear' id='c'><ref id='a'/></coat>", 54,
     "<ref id=\"a\"/>, which is a <skin>, cannot stand inside <coat type=\"clear\">; it belongs inside <scene>"},
    {"ReferenceToADefinition", "<coat type='clear' id='a'/><ref id='a'/>", 28,
     "<ref id=\"a\"/>, which is a <coat>, cannot stand inside <scene>; it belongs inside <skin> or <coat>"},
    {"DefinitionWithoutId", "<coat type='clear'/>", 1,
     "<coat> inside <scene> needs an id, or nothing can use it; it belongs inside <skin> or <coat>"},
    {"BothValueAndObject",
     "<skin type='plain'><color name='tint' value='1 1 1'/><picture name='tint' type='checker'/></skin>", 54,
     "property \"tint\" of <skin type=\"plain\"> is given twice; keep one"},
    {"NameWhereNoneIs", "<skin type='plain'><coat type='clear' name='tint'/></skin>", 39,
     "<coat> has no attribute \"name\"; it takes: type, id"},
    {"UnsupportedType", "<skin type='plain'><picture name='tint' type='photo'/></skin>", 47,
     "picture type \"photo\" is not supported; supported are: checker"},
    {"HoldsElements", "<coat type='clear' id='a'/><skin type='plain'><ref id='a'><x/></ref></skin>", 59,
     "<ref> cannot hold elements; write it as <ref id=\"…\"/>"},
    {"Circle", "<coat type='clear' id='a'><ref id='b'/></coat><coat type='clear' id='b'><ref id='a'/></coat>", 73,
     "this reference leads back to itself: \"a\" → \"b\" → \"a\"; break the cycle"},
    {"CircleOfOne", "<coat type='clear' id='a'><ref id='a'/></coat>", 27,
     "this reference leads back to itself: \"a\" → \"a\"; break the cycle"},
    {"CircleThroughAChild", "<coat type='clear' id='a'><coat type='clear'><ref id='a'/></coat></coat>", 46,
     "this reference leads back to itself: \"a\" → \"a\"; break the cycle"},
};
INSTANTIATE_TEST_SUITE_P(References, BadReference, ::testing::ValuesIn(kBad),
                         [](const auto& bad) { return std::string(bad.param.what); });

/// `count` definitions, each of which refers to the next `times` times.
std::string chain(int count, int times) {
  std::string text = "<scene>";
  for (int i = 0; i < count; ++i) {
    text += fmt::format("<coat type='clear' id='{}'>", i);
    if (i + 1 < count) text += line_of(times, fmt::format("<ref id='{}'/>", i + 1).c_str());
    text += "</coat>";
  }
  return text + "</scene>";
}

TEST(Dialect, LongChainsAreRefusedAndEndSoon) {
  EXPECT_FALSE(Toy(chain(References::kMaxNesting, 1)).diagnostics.has_errors());
  const Toy one(chain(References::kMaxNesting + 1, 1));
  EXPECT_EQ(one.diagnostics.error_count(), 1u) << one.messages();
  EXPECT_NE(one.messages().find("t.xml:1:34: a chain of 32 references starts here; at most 31"), std::string::npos)
      << one.messages();
  EXPECT_TRUE(Toy(chain(100'000, 1)).diagnostics.has_errors()) << "no stack overflows";
}

TEST(Dialect, AnUnknownPropertyWithAnObjectIsAWarningLikeAnyOther) {
  const char* text = "<scene><skin type='plain'><picture name='tnit' type='checker'/></skin></scene>";
  const Toy lax(text), strict(text, true);
  EXPECT_EQ(lax.diagnostics.error_count(), 0u);
  EXPECT_NE(lax.messages().find("has no property \"tnit\"; did you mean \"tint\"?"), std::string::npos)
      << lax.messages();
  EXPECT_EQ(strict.diagnostics.error_count(), 1u);
}

TEST(Dialect, TheTablesNameTheObjects) {
  const std::string page = parameter_tables(toy_dialect());
  EXPECT_NE(page.find("| `tint` | color or `<picture>` | `0.5 0.5 0.5` |"), std::string::npos) << page;
  EXPECT_NE(page.find("| `base` | `<skin>` | required |"), std::string::npos);
  EXPECT_NE(page.find("`<coat>` with an id, for `<ref>`"), std::string::npos);
}

TEST(NoriReferences, AMaterialIsARowHoweverManyUseIt) {
  const Parsed parsed = parse(scene_around(
      "<bsdf type='mirror' id='m'/><mesh type='sphere'><ref id='m'/></mesh><shape type='sphere'><ref id='m'/></shape>"
      "<mesh type='sphere'><bsdf type='mirror' id='n'/></mesh><mesh type='sphere'/><mesh type='sphere'><ref "
      "id='n'/></mesh>"));
  ASSERT_TRUE(parsed.file.has_value()) << all_messages(parsed.diagnostics);
  EXPECT_EQ(all_messages(parsed.diagnostics), "");
  const Scene& scene = parsed.scene();
  std::vector<std::uint32_t> rows;
  for (const Instance& instance : scene.instances) rows.push_back(instance.material);
  EXPECT_EQ(rows, (std::vector<std::uint32_t>{0, 0, 1, 2, 1}));
  EXPECT_EQ(scene.materials[0].name, "m");
  EXPECT_EQ(scene.materials[2].name, "diffuse");
}

TEST(NoriReferences, WhatIsDefinedAndNotUsedIsSaidAndChecked) {
  const Parsed unused = parse(scene_around("<bsdf type='mirror' id='m'/>"));
  ASSERT_TRUE(unused.file.has_value());
  EXPECT_EQ(all_messages(unused.diagnostics),
            "s.xml:2:1: nothing refers to <bsdf id=\"m\">; use it by <ref id=\"m\"/>, or remove it\n");
  EXPECT_TRUE(unused.scene().materials.empty());
  EXPECT_FALSE(parse(scene_around("<bsdf type='miror' id='m'/>")).file.has_value());
}

TEST(NoriReferences, TheScenesOfATestShareDefinitionsByTheirIds) {
  const std::string scene = "<scene><integrator type='path'/><camera type='perspective'/><mesh type='sphere'>";
  const Parsed parsed =
      parse("<test type='ttest'><string name='references' value='1 1'/>" + scene +
            "<bsdf id='m' type='mirror'/></mesh></scene>" + scene + "<ref id='m'/></mesh></scene></test>");
  ASSERT_TRUE(parsed.file.has_value()) << all_messages(parsed.diagnostics);
  for (const Scene& s : std::get<TTest>(*parsed.file).scenes) {
    ASSERT_EQ(s.materials.size(), 1u);
    EXPECT_TRUE(std::holds_alternative<MirrorBsdf>(s.materials[0].bsdf));
  }
}

TEST(MeshFacts, SmoothNormalsAreWeightedByAngle) {
  // A corner of a cube, whose face z = 0 is one square of two triangles: the diagonal must not count twice.
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {9, 9, 9}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {0, 4, 3}};
  apply_mesh_facts({.smooth_without_normals = true}, true, mesh);
  ASSERT_EQ(mesh.normals.size(), 6u);
  EXPECT_LT(glm::length(mesh.normals[0] - glm::normalize(glm::dvec3(-1, -1, -1))), 1e-12);
  EXPECT_EQ(mesh.normals[2], glm::dvec3(0, 0, -1));
  EXPECT_EQ(mesh.normals[5], glm::dvec3(0, 0, 1)) << "no triangle has it";
  mesh.normals.edit()[2] = {1, 0, 0};
  apply_mesh_facts({.smooth_without_normals = true}, true, mesh);
  EXPECT_EQ(mesh.normals[2], glm::dvec3(1, 0, 0)) << "a mesh with normals keeps them";
  mesh.normals.clear();
  apply_mesh_facts({}, true, mesh);
  EXPECT_TRUE(mesh.normals.empty());
}

TEST(MeshFacts, VPointsUpward) {
  TriangleMesh mesh;
  mesh.uv_sets = {{{0.25f, 0.25f}}};
  apply_mesh_facts({.v_origin = VOrigin::bottom}, false, mesh);
  apply_mesh_facts({.v_origin = VOrigin::top}, true, mesh);
  EXPECT_EQ(mesh.uv_sets[0][0], glm::vec2(0.25f, 0.25f));
  apply_mesh_facts({.v_origin = VOrigin::top}, false, mesh);
  EXPECT_EQ(mesh.uv_sets[0][0], glm::vec2(0.25f, 0.75f));
}

}  // namespace
}  // namespace etendue::testing
