/// Scene files that hold what they should not: every one ends with code 3 and one sentence that has line and column.

#include "bad_inputs.h"

namespace etendue::faults {
namespace {

const char* const kAnywhere = R"(scene\.xml:\d+:\d+: )";

void expect_bad_scene(const std::string& name, const std::string& text, const std::string& words,
                      const std::string& place = kAnywhere) {
  expect_refused({name, {"scene.xml", text}, render_scene(), 3, place, words, {}});
}

/// Spellings of numbers that other programs read, or read in part.
const std::vector<std::string> kNoNumbers = {"",
                                             " ",
                                             "abc",
                                             "1x",
                                             "1.5 m",
                                             "1,5",
                                             "0x10",
                                             "0x1p3",
                                             "0b1",
                                             "nan",
                                             "-nan",
                                             "NaN(1)",
                                             "inf",
                                             "-inf",
                                             "Infinity",
                                             "1e999",
                                             "-1e999",
                                             "1e99999999999999999999",
                                             "--1",
                                             "+-1",
                                             "-+1",
                                             "1..2",
                                             "1.2.3",
                                             "1e",
                                             "1e+",
                                             "e5",
                                             ".",
                                             "-",
                                             "+",
                                             "1_000",
                                             "1'000",
                                             "1.0f",
                                             "1d0",
                                             "\xef\xbc\x91",
                                             "\xd9\xa3",
                                             "\xc2\xbd",
                                             "1\xc2\xa0",
                                             "\u22121",
                                             "&#x200b;1",
                                             "$1",
                                             "1%",
                                             "1/2",
                                             "(1)",
                                             "true",
                                             "1e-5e",
                                             "0.1.",
                                             "1e1.5",
                                             "0 0 0 0 0 0 0 0 0",
                                             std::string(5000, '9') + "x"};

TEST(BadScene, NumbersThatAreNone) {
  for (const std::string& number : kNoNumbers) {
    const std::string value = "value=\"" + number + "\"/>";
    expect_bad_scene("radius " + number,
                     scene_with("<mesh type=\"sphere\"><float name=\"radius\" " + value + "</mesh>"),
                     "\"radius\" of <mesh type=\"sphere\">", R"(scene\.xml:2:\d+: )");
    expect_bad_scene("sampleCount " + number,
                     scene_with("<sampler type=\"independent\"><integer name=\"sampleCount\" " + value + "</sampler>"),
                     "\"sampleCount\"", R"(scene\.xml:2:\d+: )");
    expect_bad_scene("radiance " + number,
                     scene_with("<mesh type=\"sphere\"><emitter type=\"area\"><color name=\"radiance\" value=\"1 2 " +
                                number + "\"/></emitter></mesh>"),
                     "\"radiance\" of <emitter type=\"area\">", R"(scene\.xml:2:\d+: )");
    expect_bad_scene(
        "angle " + number,
        scene_with("<mesh type=\"obj\"><string name=\"filename\" value=\"m.obj\"/><transform name=\"toWorld\">"
                   "<rotate axis=\"0 1 0\" angle=\"" +
                   number + "\"/></transform></mesh>"),
        "\"angle\" of <rotate>", R"(scene\.xml:2:\d+: )");
  }
}

/// A property whose values are numbers, but out of range. It stands in elements within one another, outermost first.
struct OutOfRange {
  std::vector<std::string> elements;
  std::string tag, name;
  std::vector<std::string> values;
};

const std::vector<std::string> kNoSizes = {"0",  "-1", "65537", "2147483648", "4294967297", "9223372036854775808",
                                           "1.5"};
const std::string kCamera = "camera type=\"perspective\"", kSphere = "mesh type=\"sphere\"",
                  kIntegrator = "integrator type=\"path\"", kGlass = "bsdf type=\"dielectric\"";

const std::vector<OutOfRange> kOutOfRange = {
    {{kCamera}, "integer", "width", kNoSizes},
    {{kCamera}, "integer", "height", kNoSizes},
    {{kCamera}, "float", "fov", {"0", "-0", "-1", "180", "180.00001", "360", "1e300", "1e-999"}},
    {{kCamera}, "float", "nearClip", {"-1", "1e5", "1e10"}},
    {{kCamera}, "float", "farClip", {"0", "-1", "1e-5"}},
    {{kIntegrator}, "integer", "maxDepth", {"0", "-1", "4294967296", "99999999999"}},
    {{kIntegrator}, "integer", "rrDepth", {"-1", "4294967296"}},
    {{"sampler type=\"independent\""}, "integer", "sampleCount", {"0", "-1", "4294967296", "18446744073709551616"}},
    {{kCamera, "rfilter type=\"gaussian\""}, "float", "radius", {"0", "-1", "33", "1e300"}},
    {{kCamera, "rfilter type=\"gaussian\""}, "float", "stddev", {"0", "-1", "1e9"}},
    {{kCamera, "rfilter type=\"mitchell\""}, "float", "B", {"-9", "1e9"}},
    {{kSphere}, "float", "radius", {"0", "-1", "1e10", "1e308"}},
    {{kSphere}, "point", "center", {"1e10 0 0", "0 -1e300 0", "0 0", "0 0 0 0", ""}},
    {{kSphere, kGlass}, "float", "intIOR", {"0", "-1.5", "1001", "1e300"}},
    {{kSphere, kGlass}, "float", "extIOR", {"0", "-1", "1e-999"}},
    {{kSphere, "bsdf type=\"diffuse\""}, "color", "albedo", {"1e10 0 0", "1e10", "0 -2000 0", "0.5 0.5"}},
    {{kSphere, "emitter type=\"area\""},
     "color",
     "radiance",
     {"-1 1 1", "1 1 -1e-30", "1e30 1 1", "1e-30 0 0", "-1", "1 2"}},
    {{}, "color", "sky_top", {"-1 0 0", "1e21 0 0", "1 1"}}};

TEST(BadScene, NumbersOutOfRange) {
  for (const OutOfRange& bad : kOutOfRange) {
    for (const std::string& value : bad.values) {
      std::string content = "<" + bad.tag + " name=\"" + bad.name + "\" value=\"" + value + "\"/>";
      for (auto element = bad.elements.rbegin(); element != bad.elements.rend(); ++element)
        content = "<" + *element + ">" + content + "</" + element->substr(0, element->find(' ')) + ">";
      for (const std::string& needed : {kCamera, kIntegrator})
        if (bad.elements.empty() || bad.elements.front() != needed) content += "<" + needed + "/>";
      expect_bad_scene(bad.name + " " + value, "<scene>" + content + "</scene>", bad.name);
    }
  }
}

TEST(BadScene, FilmsThatAreTooLarge) {
  const auto sized = [](const std::string& width, const std::string& height) {
    return "<scene><integrator type=\"path\"/><camera type=\"perspective\"><integer name=\"width\" value=\"" + width +
           "\"/><integer name=\"height\" value=\"" + height + "\"/></camera></scene>";
  };
  expect_bad_scene("65536²", sized("65536", "65536"), "65536 × 65536 = 4294967296 pixels; at most 67108864");
  expect_bad_scene("just too large", sized("8193", "8192"), "at most 67108864");
}

TEST(BadScene, Transforms) {
  const std::vector<std::pair<std::string, std::string>> operations = {
      {"<translate value=\"1 2\"/>", "expected 3 numbers, found 2"},
      {"<translate value=\"1 2 3 4\"/>", "expected 3 numbers, found 4"},
      {"<translate value=\"1e308 0 0\"/><translate value=\"1e308 0 0\"/>", "overflows"},
      {"<translate/>", "lacks its attribute \"value\""},
      {"<translate value=\"1 2 3\" x=\"1\"/>", "has no attribute \"x\""},
      {"<translate value=\"1 2 3\"><scale value=\"1 1 1\"/></translate>", "cannot hold elements"},
      {"<scale value=\"0 1 1\"/>", "singular"},
      {"<scale value=\"1\"/>", "expected 3 numbers, found 1"},
      {"<scale value=\"1e-200 1e-200 1e-200\"/><scale value=\"1e-200 1e-200 1e-200\"/>", "singular or overflows"},
      {"<scale value=\"1e200 1e200 1e200\"/><scale value=\"1e200 1e200 1e200\"/>", "singular or overflows"},
      {"<rotate angle=\"30\" axis=\"0 0 0\"/>", "length 0"},
      {"<rotate angle=\"1e999\" axis=\"0 1 0\"/>", "too large"},
      {"<rotate axis=\"0 1 0\"/>", "lacks its attribute \"angle\""},
      {"<matrix value=\"1 2 3\"/>", "needs 16 numbers"},
      {"<matrix value=\"0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1\"/>", "singular"},
      {"<matrix value=\"1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 2\"/>", "an affine matrix has 0 0 0 1"},
      {"<matrix value=\"1 0 0 0 0 1 0 0 0 0 1 0 0.1 0 0 1\"/>", "an affine matrix has 0 0 0 1"},
      {"<matrix value=\"1 1 0 0 1 1 0 0 0 0 1 0 0 0 0 1\"/>", "singular"},
      {"<lookat origin=\"0 0 0\" target=\"0 0 0\" up=\"0 1 0\"/>", "target at its origin"},
      {"<lookat origin=\"0 0 0\" target=\"0 0 1\" up=\"0 0 0\"/>", "length 0"},
      {"<lookat origin=\"0 0 0\" up=\"0 1 0\"/>", "lacks its attribute \"target\""},
      {"<lookat origin=\"1e300 0 0\" target=\"-1e300 0 0\" up=\"0 1 0\"/>", ""},
      {"<shear value=\"1 0 0\"/>", "no operation \"shear\""},
      {"<lookAt origin=\"0 0 0\" target=\"0 0 1\" up=\"0 1 0\"/>", "did you mean \"lookat\"?"},
      {"<float name=\"x\" value=\"1\"/>", "no operation \"float\""},
      {"text", "stray text"}};
  for (const auto& [operation, words] : operations) {
    const std::string transform = "<transform name=\"toWorld\">" + operation + "</transform>";
    expect_bad_scene(
        operation,
        "<scene><integrator type=\"path\"/>\n<camera type=\"perspective\">" + transform + "</camera></scene>", words,
        R"(scene\.xml:2:\d+: )");
  }
}

using Contents = std::vector<std::pair<std::string, std::string>>;

/// Each content of a scene is refused with a sentence that contains these words.
void expect_bad_contents(const Contents& contents) {
  for (const auto& [content, words] : contents) expect_bad_scene(content, scene_with(content), words);
}

TEST(BadScene, TagsAndProperties) {
  expect_bad_contents(
      {{"<mesh/>", "lacks its attribute \"type\""},
       {"<mesh type=\"\"/>", "unknown mesh type \"\""},
       {"<mesh type=\"sphear\"/>", "did you mean \"sphere\"?"},
       {"<mesh type=\"sphere\" type=\"sphere\"/>", "given twice"},
       {"<mesh type=\"sphere\" colour=\"1\"/>", "has no attribute \"colour\""},
       {"<mesh type='sphere\"/>", "no closing quote"},
       {"<mesh type=sphere/>", "in quotes"},
       {"<mesh type=\"sphere\"", "'<' inside the tag"},
       {"<mesh type=\"sphere\">", "does not close <mesh>"},
       {"<Mesh type=\"sphere\"/>", "did you mean \"mesh\"?"},
       {"<form type=\"sphere\"/>", "unknown tag \"form\""},
       {"<mesh type=\"heightfield\"/>", "not supported; supported are: obj, "},
       {"<mesh type=\"sphere\"><mesh type=\"sphere\"/></mesh>", "cannot stand inside"},
       {"<mesh type=\"sphere\"><bsdf type=\"mirror\"/><bsdf type=\"mirror\"/></mesh>", "more than one <bsdf>"},
       {"<mesh type=\"sphere\"><emitter type=\"area\"/></mesh>", "needs its property \"radiance\""},
       {"<emitter type=\"point\"/>", "has neither \"intensity\" nor \"power\""},
       {"<mesh type=\"sphere\"><bsdf type=\"phong\"/></mesh>", "not supported; supported are: diffuse"},
       {"<mesh type=\"sphere\"><bsdf type=\"difuse\"/></mesh>", "did you mean \"diffuse\"?"},
       {"<mesh type=\"sphere\"><float name=\"radius\" value=\"1\"/><float name=\"radius\" value=\"2\"/></mesh>",
        "given twice"},
       {"<mesh type=\"sphere\"><string name=\"radius\" value=\"1\"/></mesh>", "is of type float, not string"},
       {"<mesh type=\"sphere\"><float value=\"1\"/></mesh>", "lacks its attribute \"name\""},
       {"<mesh type=\"sphere\"><float name=\"radius\"/></mesh>", "lacks its attribute \"value\""},
       {"<mesh type=\"sphere\"><float name=\"radius\" value=\"1\">1</float></mesh>", "stray text"}});
}

TEST(BadScene, NamesOfFiles) {
  expect_bad_contents(
      {{"<mesh type=\"obj\"/>", "needs its property \"filename\""},
       {"<mesh type=\"obj\"><string name=\"filename\" value=\"\"/></mesh>", "is empty"},
       {"<mesh type=\"obj\"><string name=\"filename\" value=\" \"/></mesh>", "is empty"},
       {"<mesh type=\"obj\"><string name=\"filename\" value=\"none.obj\"/></mesh>", "cannot open the file"},
       {"<mesh type=\"obj\"><string name=\"filename\" value=\".\"/></mesh>", "this is a folder"},
       {"<mesh type=\"obj\"><string name=\"filename\" value=\"scene.xml/x.obj\"/></mesh>", "cannot open the file"},
       {"<mesh type=\"obj\"><string name=\"filename\" value=\"/dev/zero\"/></mesh>", "not a regular file"},
       {"<mesh type=\"obj\"><string name=\"filename\" value=\"/dev/stdin\"/></mesh>", "mesh"},
       {"<mesh type=\"obj\"><string name=\"filename\" value=\"/proc/self/fd\"/></mesh>", "this is a folder"},
       {"<mesh type=\"obj\"><string name=\"filename\" value=\"" + std::string(5000, 'a') + "\"/></mesh>",
        "File name too long"}});
}

TEST(BadScene, Places) {
  expect_bad_contents({{"<camera type=\"perspective\"/>", "more than one <camera>"},
                       {"<camera type=\"thinlens\"/>", "more than one <camera>"},
                       {"<integrator type=\"path\"/>", "more than one <integrator>"},
                       {"<sampler type=\"independent\"/><sampler type=\"independent\"/>", "more than one <sampler>"},
                       {"<rfilter type=\"box\"/>", "belongs inside <camera>"},
                       {"<bsdf type=\"diffuse\"/>", "belongs inside <mesh>"},
                       {"<emitter type=\"area\"><color name=\"radiance\" value=\"1 1 1\"/></emitter>",
                        "belongs in the mesh that emits"},
                       {"<medium type=\"homogeneous\"/>", "not supported"},
                       {"<scene/>", "belongs inside <test>"},
                       {"<boolean name=\"nee\" value=\"1\"/>", "write true or false"},
                       {"<boolean name=\"nee\" value=\"maybe\"/>", "write true or false"}});
}

TEST(BadScene, Markup) {
  expect_bad_contents({{"<![CDATA[<mesh type=\"sphere\"/>]]>", "text between tags"},
                       {"hello", "stray text \"hello\""},
                       {"<!-- -", "never closed"},
                       {"<?pi", "never closed"},
                       {"<!ENTITY a \"b\">", "not supported"},
                       {"<mesh type=\"&lol;\"/>", "entity \"lol\" is not defined"},
                       {"<mesh type=\"&#0;\"/>", "not a character"},
                       {"<mesh type=\"&#xD800;\"/>", "not a character"},
                       {"<mesh type=\"&#99999999999;\"/>", "not a character"},
                       {"<mesh type=\"a&b\"/>", "&amp;"},
                       {"</scene><scene>", "more after the root"},
                       {"</mesh>", "does not close"},
                       {"< mesh type=\"sphere\"/>", "expected the name"},
                       {"<mesh type=\"sphere\"/ >", "expected a blank before the next attribute"},
                       {"<mesh\ntype=\"sphere\"\nx=\"1\"\n/>", "has no attribute \"x\""}});
}

TEST(BadScene, Roots) {
  const std::vector<std::pair<std::string, std::string>> texts = {
      {"", "no element"},
      {" ", "no element"},
      {"\n\n\n", "no element"},
      {"<", "expected the name"},
      {">", "text outside"},
      {"</scene>", "expected the name"},
      {"<scene", "never closed"},
      {"<scene>", "never closed"},
      {"<scene/>", "needs a <camera>"},
      {"<scene><camera type=\"perspective\"/></scene>", "needs a <integrator>"},
      {"<scene></scene><scene></scene>", "more after the root"},
      {"<scene type=\"x\"/>", "has no attribute \"type\""},
      {"<mesh type=\"sphere\"/>", "one <scene> or one <test>"},
      {"<html><body/></html>", "root element is \"html\""},
      {"<svg xmlns=\"http://www.w3.org/2000/svg\"/>", "root element is \"svg\""},
      {"{\"scene\": {}}", "text outside"},
      {"# Blender v3.4 OBJ File\nv 0 0 0\n", "text outside"},
      {"\x89PNG\r\n\x1a\n", "not valid UTF-8"},
      {std::string("v/1\x01\0\0", 6), "control character 0x01"},
      {std::string("\x7f"
                   "ELF\x02\x01\x01\0",
                   8),
       "control character 0x02"},
      {std::string("\0\0\0\0", 4), "UTF-16, UTF-32 or binary"},
      {"\x1f\x8b\x08\x08", "control character 0x1f"},
      {std::string("\xff\xfe<\0s\0c\0e\0n\0e\0>\0", 16), "UTF-16"},
      {std::string("\xfe\xff\0<\0s", 6), "UTF-16"},
      {std::string("\xff\xfe\0\0<\0\0\0", 8), "UTF-16, UTF-32"},
      {"\xef\xbb\xbf", "no element"},
      {"\xef\xbb\xbf\xef\xbb\xbf<scene/>", "text outside"},
      {"<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><scene>\xe4</scene>", "not valid UTF-8"},
      {"<!DOCTYPE scene SYSTEM \"file:///etc/passwd\"><scene/>", "not supported"},
      {"<!DOCTYPE s [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\">]><scene>&b;</scene>",
       "not supported"},
      {"<!DOCTYPE s [<!ENTITY x SYSTEM \"/etc/passwd\">]><scene>&x;</scene>", "not supported"},
      {"<test type=\"ttest\"/>", ""},
      {"<test type=\"chi2test\"/>", "needs a <bsdf>"},
      {"<test/>", "lacks its attribute \"type\""},
      {"<scene>\xed\xa0\x80</scene>", "not valid UTF-8"},
      {"<scene>\xf4\x90\x80\x80</scene>", "not valid UTF-8"},
      {"<scene>\xc3", "not valid UTF-8"},
      {std::string("<scene>\0</scene>", 16), "control character 0x00"}};
  for (const auto& [text, words] : texts) expect_bad_scene(text, text, words);
}

TEST(BadScene, TestFilesThatAreNoScenes) {
  const std::string sky = "<scene><integrator type=\"path\"/><camera type=\"perspective\"/></scene>";
  const auto refused = [](const std::string& name, const std::string& text, const std::string& words,
                          const char* command) {
    expect_refused({name, {"scene.xml", text}, {command, "scene.xml"}, 3, R"(scene\.xml)", words, {}});
  };
  refused("a scene for ttest", sky, "ttest", "ttest");
  refused("a scene for chi2", sky, "chi2test", "chi2");
  refused("counts", "<test type=\"ttest\"><string name=\"references\" value=\"1 2\"/>" + sky + "</test>",
          "2 references for 1 scenes", "ttest");
  refused("no references", "<test type=\"ttest\">" + sky + "</test>", "needs its property \"references\"", "ttest");
  refused("nan", "<test type=\"ttest\"><string name=\"references\" value=\"nan\"/>" + sky + "</test>",
          "not a finite number", "ttest");
  refused("mixed",
          "<test type=\"ttest\"><string name=\"references\" value=\"1\"/>" + sky + "<bsdf type=\"diffuse\"/></test>",
          "mixes", "ttest");
  refused("angles", "<test type=\"ttest\"><string name=\"references\" value=\"1\"/><bsdf type=\"diffuse\"/></test>",
          "\"angles\"", "ttest");
  refused("grazing",
          "<test type=\"ttest\"><string name=\"references\" value=\"1\"/><string name=\"angles\" value=\"90\"/>"
          "<bsdf type=\"diffuse\"/></test>",
          "an angle is 90", "ttest");
  refused("resolution",
          "<test type=\"chi2test\"><integer name=\"resolution\" value=\"100000\"/><bsdf type=\"diffuse\"/></test>",
          "out of range", "chi2");
  expect_refused({"render a test",
                  {"scene.xml", "<test type=\"chi2test\"><bsdf type=\"diffuse\"/></test>"},
                  render_scene(),
                  3,
                  R"(scene\.xml)",
                  "run it with etendue chi2",
                  {}});
}

std::string ten_megabytes(char byte) {
  std::string bytes;
  bytes.resize(10'000'000, byte);
  return bytes;
}

TEST(BadScene, FilesMadeToExhaustTheReader) {
  std::string deep, bombs, unknown;
  for (int i = 0; i < 100000; ++i) deep += "<mesh type=\"sphere\">";
  for (int i = 0; i < 1000; ++i) bombs += "<mesh type=\"&a" + std::to_string(i) + ";\"/>";
  for (int i = 0; i < 200000; ++i) unknown += "<x/>";
  expect_bad_scene("100 000 levels", "<scene>" + deep, "nested deeper");
  expect_bad_scene("entities", scene_with(bombs), "not defined");
  expect_bad_scene("unknown tags", scene_with(unknown), "unknown tag");
  expect_bad_scene("10 MB of blanks", ten_megabytes(' '), "no element");
  expect_bad_scene("10 MB of line ends", ten_megabytes('\n'), "no element");
  expect_bad_scene("10 MB of carriage returns", "<scene>" + ten_megabytes('\r'), "never closed");
  expect_bad_scene("10 MB of an attribute", "<scene a=\"" + ten_megabytes('a'), "no closing quote");
  // Not "<" + …: GCC 12 takes the string for one of 2^63 bytes.
  expect_bad_scene("10 MB of a name", std::string("<").append(ten_megabytes('a')).append("/>"), "root element");
  expect_bad_scene(
      "10 MB of a number",
      scene_with("<mesh type=\"sphere\"><float name=\"radius\" value=\"" + ten_megabytes('1') + "\"/></mesh>"),
      "too large");
  expect_bad_scene("10 MB of a comment", "<!--" + ten_megabytes('-'), "never closed");
  expect_bad_scene("10 MB of opened comments", std::string(100'000, '<'), "expected the name");
  std::string many;
  for (int i = 0; i < 100'000; ++i) many += "<mesh type=\"obj\"><string name=\"filename\" value=\"no.obj\"/></mesh>";
  expect_bad_scene("100 000 missing meshes", scene_with(many), "cannot open");
  expect_refused({"more than 32 MiB",
                  {"scene.xml", ten_megabytes(' ') + ten_megabytes(' ') + ten_megabytes(' ') + ten_megabytes(' ')},
                  render_scene(),
                  3,
                  R"(scene\.xml: )",
                  "at most 33554432",
                  {}});
}

}  // namespace
}  // namespace etendue::faults
