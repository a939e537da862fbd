// Every kind of bad scene file: where the first error is reported and what it says.

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "formats_testing.h"

namespace etendue::testing {
namespace {

struct BadInput {
  const char* what;
  std::string text;
  int line;
  int column;
  const char* says;
};

std::string in_camera(const std::string& content) {
  return "<scene><integrator type=\"path\"/>\n<camera type=\"perspective\">\n" + content + "\n</camera></scene>";
}
std::string in_transform(const std::string& content) {
  return in_camera("<transform name=\"toWorld\">\n" + content + "\n</transform>");
}
std::string in_mesh(const std::string& content) {
  return scene_around("<mesh type=\"sphere\">\n" + content + "\n</mesh>");
}
std::string in_ttest(const std::string& content) {
  return "<test type=\"ttest\">\n" + content + "\n</test>";
}
std::string deep(int levels) {
  std::string text;
  for (int i = 0; i < levels; ++i) text += "<a>";
  return text;
}

void PrintTo(const BadInput& bad, std::ostream* out) {
  *out << bad.what;
}

class BadScene : public ::testing::TestWithParam<BadInput> {};

TEST_P(BadScene, IsRefusedAtItsPlace) {
  const BadInput& bad = GetParam();
  const Parsed parsed = parse(bad.text);
  EXPECT_FALSE(parsed.file.has_value());
  const auto& list = parsed.diagnostics.list();
  const auto first =
      std::find_if(list.begin(), list.end(), [](const Diagnostic& d) { return d.severity == Severity::error; });
  ASSERT_NE(first, list.end()) << "no error";
  EXPECT_EQ(first->position.file, "s.xml");
  EXPECT_EQ(first->position.line, bad.line) << to_string(*first);
  EXPECT_EQ(first->position.column, bad.column) << to_string(*first);
  EXPECT_NE(first->message.find(bad.says), std::string::npos) << to_string(*first);
  EXPECT_EQ(first->message.find('\n'), std::string::npos) << "one sentence is one line";
}

std::string name_of(const ::testing::TestParamInfo<BadInput>& info) {
  return info.param.what;
}

const BadInput kXml[] = {
    {"Empty", "", 1, 1, "no element"},
    {"Blank", " \n\t ", 2, 3, "no element"},
    {"TextOnly", "hello", 1, 1, "text outside the root"},
    {"OnlyComment", "<!-- x -->", 1, 11, "no element"},
    {"UnclosedComment", "<!-- x", 1, 1, "comment is never closed"},
    {"UnclosedInstruction", "<?xml version=\"1.0\"", 1, 1, "processing instruction is never closed"},
    {"UnclosedRoot", "<scene>\n", 1, 1, "<scene> is never closed"},
    {"UnclosedTag", "<scene", 1, 1, "never closed with"},
    {"WrongClose", "<scene>\n <mesh type=\"sphere\">\n </scene>", 3, 2,
     "does not close <mesh>, which was opened at line 2"},
    {"TwoRoots", "<scene></scene>\n<scene/>", 2, 1, "more after the root"},
    {"TextAfterRoot", "<scene></scene> x", 1, 17, "text outside the root"},
    {"Doctype", "<!DOCTYPE scene [<!ENTITY a \"b\">]><scene/>", 1, 1, "entity declarations are not supported"},
    {"UnknownEntity", scene_around("<mesh type=\"&foo;\"/>"), 2, 13, "entity \"foo\" is not defined"},
    {"BareAmpersand", scene_around("<mesh type=\"a & b\"/>"), 2, 15, "&amp;"},
    {"NulReference", scene_around("<mesh type=\"&#0;\"/>"), 2, 13, "not a character"},
    {"HugeReference", scene_around("<mesh type=\"&#x110000;\"/>"), 2, 13, "not a character"},
    {"SurrogateReference", scene_around("<mesh type=\"&#xd800;\"/>"), 2, 13, "not a character"},
    {"DuplicateAttribute", scene_around("<mesh type=\"sphere\" type=\"obj\"/>"), 2, 21, "given twice"},
    {"NoQuotes", scene_around("<mesh type=sphere/>"), 2, 12, "in quotes"},
    {"NoClosingQuote", scene_around("<mesh type=\"sphere/>"), 2, 7, "no closing quote before the next '<'"},
    {"NoClosingQuoteAtAll", "<scene type=\"x", 1, 8, "no closing quote"},
    {"NoEquals", scene_around("<mesh type/>"), 2, 11, "after attribute \"type\""},
    {"NoBlankBetween", scene_around("<mesh type=\"sphere\"x=\"1\"/>"), 2, 20, "expected a blank"},
    {"AngleInTag", scene_around("<mesh <bsdf/>"), 2, 7, "inside the tag"},
    {"BadName", scene_around("<1mesh/>"), 2, 2, "expected the name of an element"},
    {"StrayText", scene_around("  hello <mesh type=\"sphere\"/>"), 2, 3, "stray text \"hello\""},
    {"StrayTextAfterUmlauts", scene_around("<!-- äöü€ --> x"), 2, 15, "stray text"},
    {"Cdata", scene_around("<![CDATA[x]]>"), 2, 1, "text between tags"},
    {"ControlCharacter", scene_around("\x01"), 2, 1, "control character 0x01"},
    {"Latin1", scene_around("<!-- \xe4 -->"), 2, 6, "not valid UTF-8"},
    {"Overlong", scene_around("<!-- \xc0\x80 -->"), 2, 6, "not valid UTF-8"},
    {"DeclaredLatin1", "<?xml version=\"1.0\" encoding=\"latin1\"?><scene>ä</scene>", 1, 31,
     "encoding \"latin1\" is not supported"},
    {"Utf16", std::string("\xff\xfe<\0s\0", 6), 1, 1, "UTF-16"},
    {"Utf16NoMark", std::string("<\0s\0c\0", 6), 1, 1, "UTF-16"},
    {"TooDeep", deep(100), 1, 97, "nested deeper than 32"},
    {"TooManyAttributes",
     "<scene a='' b='' c='' d='' e='' f='' g='' h='' i='' j='' k='' l='' m='' n='' o='' p='' q=''/>", 1, 88,
     "more than 16 attributes"},
    {"CarriageReturns", "<scene>\r\r<mash/></scene>", 3, 1, "unknown tag \"mash\"; did you mean \"mesh\"?"},
    {"DosLines", "<scene>\r\n\r\n <mash/></scene>", 3, 2, "unknown tag"},
    {"ByteOrderMark", "\xef\xbb\xbf<scen/>", 1, 1, "root element is \"scen\""},
};
INSTANTIATE_TEST_SUITE_P(Xml, BadScene, ::testing::ValuesIn(kXml), name_of);

const BadInput kGrammar[] = {
    {"WrongRoot", "<mesh type=\"sphere\"/>", 1, 1, "one <scene> or one <test>"},
    {"TestWithoutType", "<test/>", 1, 1, "lacks its attribute \"type\""},
    {"UnknownTest", "<test type=\"utest\"/>", 1, 13, "did you mean \"ttest\"?"},
    {"SceneWithType", "<scene type=\"x\"/>", 1, 8, "<scene> has no attribute \"type\""},
    {"NoIntegrator", "<scene><camera type=\"perspective\"/></scene>", 1, 1, "needs a <integrator>"},
    {"NoCamera", "<scene><integrator type=\"path\"/></scene>", 1, 1, "needs a <camera>"},
    {"TwoCameras", scene_around("<camera type=\"perspective\"/>"), 2, 1, "more than one <camera>"},
    {"TwoSamplers", scene_around("<sampler type=\"independent\"/>\n<sampler type=\"independent\"/>"), 3, 1,
     "more than one <sampler>"},
    {"UnknownTag", scene_around("<bsfd type=\"diffuse\"/>"), 2, 1, "unknown tag \"bsfd\"; did you mean \"bsdf\"?"},
    {"UnknownType", in_mesh("<bsdf type=\"difuse\"/>"), 3, 13,
     "did you mean \"diffuse\"?; supported are: diffuse, mirror, dielectric"},
    {"Metal", in_mesh("<bsdf type=\"conductor\"><string name=\"material\" value=\"Aux\"/></bsdf>"), 3, 55,
     "there is no material \"Aux\"; did you mean \"Au\"?"},
    {"MetalTwice",
     in_mesh("<bsdf type=\"conductor\"><string name=\"material\" value=\"Au\"/><color name=\"eta\" value=\"1 1 1\"/>"
             "<color name=\"k\" value=\"1 1 1\"/></bsdf>"),
     3, 55, "both a material and an index of refraction"},
    {"HalfAMetal", in_mesh("<bsdf type=\"conductor\"><color name=\"k\" value=\"1 1 1\"/></bsdf>"), 3, 47,
     "give both \"eta\" and \"k\""},
    {"Distribution", in_mesh("<bsdf type=\"roughconductor\"><string name=\"distribution\" value=\"phong\"/></bsdf>"), 3,
     64, "use beckmann or ggx"},
    {"RoughnessTwice",
     in_mesh("<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"0.1\"/><float name=\"alpha_u\" "
             "value=\"0.2\"/></bsdf>"),
     3, 56, "the roughness is given twice"},
    {"TooSmooth", in_mesh("<bsdf type=\"microfacet\"><float name=\"alpha\" value=\"1e-4\"/></bsdf>"), 3, 52,
     "allowed is 0.001 … 1"},
    {"PointLight", in_mesh("<emitter type=\"point\"><color name=\"power\" value=\"1 1 1\"/></emitter>"), 3, 1,
     "point is a light of its own, not of a mesh"},
    {"NoIntensity", scene_around("<emitter type=\"point\"/>"), 2, 1, "has neither \"intensity\" nor \"power\""},
    {"IntensityAndPower",
     scene_around(
         "<emitter type=\"point\"><color name=\"intensity\" value=\"1 1 1\"/>\n<color name=\"power\" value=\"1 1 "
         "1\"/></emitter>"),
     3, 28, "keep one of them"},
    {"PositionAndTransform",
     scene_around("<emitter type=\"point\"><color name=\"power\" value=\"1 1 1\"/><transform "
                  "name=\"toWorld\"/>\n<point name=\"position\" value=\"1 1 1\"/></emitter>"),
     3, 31, "both \"position\" and \"toWorld\""},
    {"BeamWiderThanCone",
     scene_around("<emitter type=\"spot\"><color name=\"power\" value=\"1 1 1\"/>\n<float name=\"beamWidth\" "
                  "value=\"30\"/></emitter>"),
     3, 32, "the beam must be within the cone"},
    {"TwoLanguagesOfCones",
     scene_around("<emitter type=\"spot\"><color name=\"power\" value=\"1 1 1\"/><float name=\"totalWidth\" "
                  "value=\"30\"/>\n<float name=\"cutoffAngle\" value=\"30\"/></emitter>"),
     3, 34, "two names for one cone"},
    {"Falloff",
     scene_around("<emitter type=\"spot\"><color name=\"power\" value=\"1 1 1\"/>\n<string name=\"falloff\" "
                  "value=\"linaer\"/></emitter>"),
     3, 31, "did you mean \"linear\""},
    {"NoDirection",
     scene_around("<emitter type=\"directional\"><color name=\"irradiance\" value=\"1 1 1\"/>\n<vector "
                  "name=\"direction\" value=\"0 0 0\"/></emitter>"),
     3, 33, "is 0 0 0; give one"},
    {"TargetOfASpot",
     scene_around("<emitter type=\"spot\"><color name=\"power\" value=\"1 1 1\"/><point name=\"position\" value=\"1 1 "
                  "1\"/>\n<point name=\"target\" value=\"1 1 1\"/></emitter>"),
     3, 29, "is at its position"},
    {"UnevenLight",
     scene_around("<emitter type=\"point\"><color name=\"power\" value=\"1 1 1\"/>\n<transform name=\"toWorld\"><scale "
                  "value=\"1 2 1\"/></transform></emitter>"),
     3, 1, "scales it unevenly or shears it"},
    {"CropTooLarge",
     "<scene><integrator type=\"path\"/>\n<camera type=\"perspective\"><integer name=\"cropOffsetX\" "
     "value=\"1280\"/></camera></scene>",
     2, 63, "do not fit into a film of 1280"},
    {"FovAxis",
     "<scene><integrator type=\"path\"/>\n<camera type=\"perspective\"><string name=\"fovAxis\" "
     "value=\"z\"/></camera></scene>",
     2, 58, "\"z\" is not an axis of the field of view"},
    {"Radiosity", "<scene><camera type=\"perspective\"/>\n<integrator type=\"radiosity\"/></scene>", 2, 19,
     "not supported; supported are: path, path_mats"},
    {"Medium", scene_around("<medium type=\"homogeneous\"/>"), 2, 1, "<medium> is not supported"},
    {"Phase", scene_around("<phase type=\"hg\"/>"), 2, 1, "<phase> is not supported"},
    {"TextureWithoutFile", in_mesh("<bsdf type=\"diffuse\"><texture name=\"albedo\" type=\"bitmap\"/></bsdf>"), 3, 22,
     "needs its property \"filename\""},
    {"TextureFileMissing",
     in_mesh("<bsdf type=\"diffuse\"><texture name=\"albedo\" type=\"bitmap\">\n<string name=\"filename\" "
             "value=\"no-such.png\"/></texture></bsdf>"),
     4, 32, "no-such.png"},
    {"TextureWrap",
     in_mesh("<bsdf type=\"diffuse\"><texture name=\"albedo\" type=\"bitmap\">\n<string name=\"wrap_mode\" "
             "value=\"miror\"/><string name=\"filename\" value=\"no-such.png\"/></texture></bsdf>"),
     4, 33, "did you mean \"mirror\"?"},
    {"TextureFilter",
     in_mesh("<bsdf type=\"diffuse\"><texture name=\"albedo\" type=\"bitmap\">\n<string name=\"filter_type\" "
             "value=\"cubic\"/><string name=\"filename\" value=\"no-such.png\"/></texture></bsdf>"),
     4, 35, "known are bilinear and nearest"},
    {"TextureScale",
     in_mesh("<bsdf type=\"diffuse\"><texture name=\"albedo\" type=\"checkerboard_color\">\n<vector name=\"scale\" "
             "value=\"0,1\"/></texture></bsdf>"),
     4, 29, "a scale of 0 leaves no squares"},
    {"TexturePair",
     in_mesh("<bsdf type=\"diffuse\"><texture name=\"albedo\" type=\"checkerboard_color\">\n<point name=\"delta\" "
             "value=\"0 0 0\"/></texture></bsdf>"),
     4, 28, "expected 2 numbers, found 3"},
    {"TextureAttribute",
     in_mesh("<bsdf type=\"diffuse\"><texture name=\"albedo\" type=\"mesh_attribute\">\n<string name=\"attribute\" "
             "value=\"colour\"/></texture></bsdf>"),
     4, 33, "known are vertex_color and face_color"},
    {"TextureOfASphere", in_mesh("<bsdf type=\"diffuse\"><texture name=\"albedo\" type=\"mesh_attribute\"/></bsdf>"), 2,
     1, "has no colours of vertices, which its albedo needs"},
    {"MissingType", scene_around("<mesh/>"), 2, 1, "<mesh> lacks its attribute \"type\""},
    {"MistypedAttribute", scene_around("<mesh tpye=\"sphere\"/>"), 2, 7,
     "no attribute \"tpye\"; did you mean \"type\"?"},
    {"ExtraAttribute", scene_around("<mesh type=\"sphere\" ad=\"a\"/>"), 2, 21, "no attribute \"ad\""},
    {"MissingName", in_mesh("<float value=\"1\"/>"), 3, 1, "lacks its attribute \"name\""},
    {"MissingValue", in_mesh("<float name=\"radius\"/>"), 3, 1, "lacks its attribute \"value\""},
    {"ExtraPropertyAttribute", in_mesh("<float name=\"radius\" value=\"1\" unit=\"m\"/>"), 3, 32,
     "no attribute \"unit\""},
    {"WrongTypeTag", in_mesh("<string name=\"radius\" value=\"1\"/>"), 3, 1, "is of type float, not string"},
    {"ColorForPoint", in_mesh("<color name=\"center\" value=\"0 0 0\"/>"), 3, 1, "is of type point, not color"},
    {"TransformForFloat", in_mesh("<transform name=\"radius\"/>"), 3, 1, "is of type float, not transform"},
    {"Twice", in_mesh("<float name=\"radius\" value=\"1\"/>\n<float name=\"radius\" value=\"2\"/>"), 4, 1,
     "given twice"},
    {"TwiceWithTransform", in_transform("<translate value=\"0 0 1\"/></transform>\n<transform name=\"toWorld\">"), 5, 1,
     "given twice"},
    {"TextInProperty", in_mesh("<float name=\"radius\" value=\"1\">2</float>"), 3, 32, "stray text"},
    {"ElementInProperty", in_mesh("<float name=\"radius\" value=\"1\"><x/></float>"), 3, 32, "cannot hold elements"},
    {"MisplacedMesh", in_mesh("<mesh type=\"sphere\"/>"), 3, 1, "belongs inside <scene>"},
    {"EmitterInScene", scene_around("<emitter type=\"area\"><color name=\"radiance\" value=\"1 1 1\"/></emitter>"), 2,
     1, "belongs in the mesh that emits"},
    {"FilterInScene", scene_around("<rfilter type=\"box\"/>"), 2, 1, "belongs inside <camera>"},
    {"SceneInScene", scene_around("<scene/>"), 2, 1, "belongs inside <test>"},
    {"TwoBsdfs", in_mesh("<bsdf type=\"mirror\"/><bsdf type=\"mirror\"/>"), 3, 22, "more than one <bsdf>"},
    {"OperationOutside", in_camera("<lookat origin=\"0 0 1\" target=\"0 0 0\" up=\"0 1 0\"/>"), 3, 1,
     "outside a <transform>"},
    {"RequiredFilename", scene_around("<mesh type=\"obj\"/>"), 2, 1, "needs its property \"filename\""},
    {"EmptyFilename", scene_around("<mesh type=\"obj\"><string name=\"filename\" value=\"  \"/></mesh>"), 2, 49,
     "is empty"},
    {"RequiredRadiance", in_mesh("<emitter type=\"area\"/>"), 3, 1, "needs its property \"radiance\""},
};
INSTANTIATE_TEST_SUITE_P(Grammar, BadScene, ::testing::ValuesIn(kGrammar), name_of);

std::string radius(const std::string& value) {
  return in_mesh("<float name=\"radius\" value=\"" + value + "\"/>");
}
std::string width(const std::string& value) {
  return in_camera("<integer name=\"width\" value=\"" + value + "\"/>");
}
std::string fov(const std::string& value) {
  return in_camera("<float name=\"fov\" value=\"" + value + "\"/>");
}
std::string ior(const std::string& value) {
  return in_mesh("<bsdf type=\"dielectric\">\n<float name=\"intIOR\" value=\"" + value + "\"/></bsdf>");
}
std::string radiance(const std::string& value) {
  return in_mesh("<emitter type=\"area\">\n<color name=\"radiance\" value=\"" + value + "\"/></emitter>");
}
std::string samples(const std::string& value) {
  return scene_around("<sampler type=\"independent\"><integer name=\"sampleCount\" value=\"" + value +
                      "\"/></sampler>");
}

std::string set_size(const std::string& value) {
  return scene_around("<sampler type=\"sobol\"><integer name=\"setSize\" value=\"" + value + "\"/></sampler>");
}

const BadInput kValues[] = {
    {"SetSizeNoPowerOfTwo", set_size("48"), 2, 54, "setSize 48 is not a power of two; use 32 or 64"},
    {"SetSizeOne", set_size("1"), 2, 54, "1 is out of range; allowed is 2 … 4096"},
    {"NotANumber", radius("abc"), 3, 29, "\"radius\" of <mesh type=\"sphere\">: \"abc\" is not a number"},
    {"EmptyNumber", radius(""), 3, 29, "\"\" is not a number"},
    {"TrailingJunk", radius("  1.5x"), 3, 31, "\"1.5x\" is not a number"},
    {"TwoNumbers", radius("1 2"), 3, 29, "not a number"},
    {"DecimalComma", radius("1,5"), 3, 29, "not a number"},
    {"Hexadecimal", radius("0x10"), 3, 29, "not a number"},
    {"NaN", radius("nan"), 3, 29, "not a finite number"},
    {"Infinity", radius("inf"), 3, 29, "not a finite number"},
    {"Overflow", radius("1e999"), 3, 29, "\"1e999\" is too large"},
    {"HugeExponent", radius("1e99999999999999999999"), 3, 29, "too large"},
    {"TwoSigns", radius("+-1"), 3, 29, "not a number"},
    {"ZeroRadius", radius("0"), 3, 29, "0 is out of range; allowed is > 0"},
    {"NegativeRadius", radius("-1"), 3, 29, "out of range"},
    {"UnderflowRadius", radius("1e-999"), 3, 29, "out of range"},
    {"HugeRadius", radius("1e10"), 3, 29, "out of range"},
    {"ZeroWidth", width("0"), 3, 30, "allowed is 1 … 65536"},
    {"NegativeWidth", width("-5"), 3, 30, "allowed is 1 … 65536"},
    {"HugeWidth", width("65537"), 3, 30, "allowed is 1 … 65536"},
    {"FloatWidth", width("640.5"), 3, 30, "not an integer"},
    {"TinyWidth", width("1e-400"), 3, 30, "0 is out of range"},
    {"ExponentWidth", width("1e400"), 3, 30, "not an integer"},
    {"HugeExponentWidth", width("1e30"), 3, 30, "too large"},
    {"OverflowWidth", width("99999999999999999999"), 3, 30, "too large"},
    {"TooManyPixels", in_camera("<integer name=\"width\" value=\"65536\"/><integer name=\"height\" value=\"65536\"/>"),
     3, 30, "65536 × 65536 = 4294967296 pixels"},
    {"FovZero", fov("0"), 3, 26, "> 0, < 180"},
    {"FovHalfTurn", fov("180"), 3, 26, "> 0, < 180"},
    {"FovNegative", fov("-30"), 3, 26, "> 0, < 180"},
    {"ClipOrder", in_camera("<float name=\"nearClip\" value=\"5\"/><float name=\"farClip\" value=\"5\"/>"), 3, 64,
     "the near clipping distance (nearClip) 5 is not less than the far one (farClip), 5"},
    {"SamplesZero", samples("0"), 2, 64, "1 … 4294967295"},
    {"SamplesTooMany", samples("4294967296"), 2, 64, "1 … 4294967295"},
    {"IorZero", ior("0"), 4, 29, "0 is out of range; allowed is 0.001 … 1000"},
    {"IorNegative", ior("-1.5"), 4, 29, "-1.5 is out of range; allowed is 0.001 … 1000"},
    {"DirectionsWithoutTexture",
     in_mesh("<bsdf type=\"gltf\">\n<color name=\"anisotropy_directions\" value=\"1 0 0\"/></bsdf>"), 4, 44,
     "\"anisotropy_directions\" is a map; give it a <texture>"},
    {"NormalsWithoutTexture", in_mesh("<bsdf type=\"diffuse\">\n<color name=\"normals\" value=\"1 0 0\"/></bsdf>"), 4,
     30, "\"normals\" is a map; give it a <texture>"},
    {"MeshTextureWithoutTexture", in_mesh("<color name=\"texture\" value=\"1 0 0\"/>"), 3, 30,
     "\"texture\" is a map; give it a <texture>"},
    {"NegativeRadiance", radiance("1 -2 3"), 4, 33, "-2 is out of range; allowed is 0"},
    {"TinyRadiance", radiance("1e-30 0 0"), 4, 31, "too small for single precision"},
    {"TwoComponents", radiance("1 2"), 4, 31, "expected 3 numbers, found 2"},
    {"FourComponents", radiance("1,2,3,4"), 4, 31, "expected 3 numbers, found 4"},
    {"BadComponent", radiance("1, 2, x"), 4, 37, "\"x\" is not a number"},
    {"BadComponentNextLine", radiance("1,\n 2,\n  x"), 6, 3, "\"x\" is not a number"},
    {"MaxDepthZero",
     "<scene><camera type=\"perspective\"/>\n<integrator type=\"path\"><integer name=\"maxDepth\" "
     "value=\"0\"/></integrator></scene>",
     2, 57, "out of range"},
    {"NegativeRrDepth",
     "<scene><camera type=\"perspective\"/>\n<integrator type=\"path\"><integer name=\"rrDepth\" "
     "value=\"-1\"/></integrator></scene>",
     2, 56, "out of range"},
    {"BadBoolean",
     "<scene><camera type=\"perspective\"/>\n<integrator type=\"path\"><boolean name=\"nee\" "
     "value=\"yes\"/></integrator></scene>",
     2, 52, "write true or false"},
    {"NegativeSky", scene_around("<color name=\"sky_top\" value=\"0 0 -1\"/>"), 2, 34, "out of range"},
};
INSTANTIATE_TEST_SUITE_P(Values, BadScene, ::testing::ValuesIn(kValues), name_of);

const BadInput kTransforms[] = {
    {"UnknownOperation", in_transform("<rotat angle=\"1\" axis=\"0 1 0\"/>"), 4, 1, "did you mean \"rotate\"?"},
    {"TranslateTwo", in_transform("<translate value=\"1 2\"/>"), 4, 19, "expected 3 numbers, found 2"},
    {"ScaleZero", in_transform("<scale value=\"1 0 1\"/>"), 4, 1, "<scale> is singular"},
    {"ScaleOverflow", in_transform("<scale value=\"1e300 1e300 1e300\"/><scale value=\"1e300 1e300 1e300\"/>"), 3, 1,
     "overflows"},
    {"RotateNoAxis", in_transform("<rotate angle=\"30\"/>"), 4, 1, "lacks its attribute \"axis\""},
    {"RotateZeroAxis", in_transform("<rotate angle=\"30\" axis=\"0 0 0\"/>"), 4, 26, "length 0"},
    {"RotateBadAngle", in_transform("<rotate angle=\"30deg\" axis=\"0 1 0\"/>"), 4, 16, "\"30deg\" is not a number"},
    {"MatrixShort", in_transform("<matrix value=\"1 0 0 0 0 1 0 0 0 0 1 0\"/>"), 4, 16,
     "16 numbers, row by row, found 12"},
    {"MatrixSingular", in_transform("<matrix value=\"1 2 3 0 2 4 6 0 0 0 1 0 0 0 0 1\"/>"), 4, 1, "singular"},
    {"MatrixProjective", in_transform("<matrix value=\"1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1\"/>"), 4, 40, "last row"},
    {"MatrixBadNumber", in_transform("<matrix value=\"1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 i\"/>"), 4, 46,
     "\"i\" is not a number"},
    {"LookatUpZero", in_transform("<lookat origin=\"0 0 0\" target=\"0 1 0\" up=\"0 0 0\"/>"), 4, 43, "length 0"},
    {"LookatSamePoint", in_transform("<lookat origin=\"1 2 3\" target=\"1 2 3\" up=\"0 1 0\"/>"), 4, 32,
     "target at its origin"},
    {"LookatNoUp", in_transform("<lookat origin=\"1 2 3\" target=\"0 0 0\"/>"), 4, 1, "lacks its attribute \"up\""},
    {"TextInTransform", in_transform("1 0 0 0"), 4, 1, "stray text"},
    {"ElementInOperation", in_transform("<scale value=\"1 1 1\"><x/></scale>"), 4, 22, "cannot hold elements"},
    {"TransformWithValue", in_camera("<transform name=\"toWorld\" value=\"1\"/>"), 3, 27, "no attribute \"value\""},
    {"CameraFarAway", in_transform("<translate value=\"0 0 1e12\"/>"), 3, 1, "the camera is at 0 0 1000000000000"},
};
INSTANTIATE_TEST_SUITE_P(Transforms, BadScene, ::testing::ValuesIn(kTransforms), name_of);

const std::string kMinimalScene = scene_around("");
const BadInput kTests[] = {
    {"Empty", in_ttest("<string name=\"references\" value=\"1\"/>"), 1, 1, "neither <scene> nor <bsdf>"},
    {"NoReferences", in_ttest(kMinimalScene), 1, 1, "needs its property \"references\""},
    {"Mismatch", in_ttest("<string name=\"references\" value=\"1, 2, 3\"/>" + kMinimalScene), 2, 34,
     "3 references for 1 scenes"},
    {"BsdfMismatch",
     in_ttest("<string name=\"references\" value=\"1 2 3\"/>\n<string name=\"angles\" value=\"0 30\"/><bsdf "
              "type=\"diffuse\"/>"),
     2, 34, "3 references for 1 bsdfs × 2 angles = 2 results"},
    {"BsdfNoAngles", in_ttest("<string name=\"references\" value=\"1\"/><bsdf type=\"diffuse\"/>"), 1, 1,
     "needs its property \"angles\""},
    {"AngleRange",
     in_ttest(
         "<string name=\"references\" value=\"1\"/>\n<string name=\"angles\" value=\"181\"/><bsdf type=\"diffuse\"/>"),
     3, 30, "out of range; allowed is 0 … 180"},
    {"Chi2AngleAlongTheSurface",
     "<test type=\"chi2test\">\n<string name=\"angles\" value=\"90\"/><bsdf type=\"diffuse\"/></test>", 2, 30,
     "an angle is 90: light along the surface meets neither side"},
    {"AngleAlongTheSurface",
     in_ttest(
         "<string name=\"references\" value=\"1\"/>\n<string name=\"angles\" value=\"90\"/><bsdf type=\"diffuse\"/>"),
     3, 30, "an angle is 90: light along the surface meets neither side"},
    {"Mixed", in_ttest("<string name=\"references\" value=\"1\"/><bsdf type=\"diffuse\"/>" + kMinimalScene), 1, 1,
     "mixes 1 scenes and 1 bsdfs"},
    {"BadReference", in_ttest("<string name=\"references\" value=\"1, b\"/>" + kMinimalScene), 2, 37,
     "\"b\" is not a number"},
    {"SignificanceOne", in_ttest("<float name=\"significanceLevel\" value=\"1\"/>"), 2, 40, "out of range"},
    {"OneSample", in_ttest("<integer name=\"sampleCount\" value=\"1\"/>"), 2, 36, "out of range"},
    {"ChiWithoutBsdf", "<test type=\"chi2test\"/>", 1, 1, "needs a <bsdf>"},
    {"ChiWithScene", "<test type=\"chi2test\">\n" + kMinimalScene + "</test>", 2, 1, "belongs inside <test>"},
    {"MeshInTest", in_ttest("<mesh type=\"sphere\"/>"), 2, 1, "belongs inside <scene>"},
};
INSTANTIATE_TEST_SUITE_P(Tests, BadScene, ::testing::ValuesIn(kTests), name_of);

TEST(SceneErrors, AllProblemsOfAFileAreListed) {
  const Parsed parsed = parse(
      "<scene>\n<integrator type=\"pth\"/>\n<camera type=\"perspective\">\n<float name=\"fov\" "
      "value=\"200\"/>\n<integer name=\"width\" value=\"0\"/>\n"
      "<transform name=\"toWorld\"><scale value=\"0 1 1\"/><lookat origin=\"0 0 0\" target=\"0 0 0\" up=\"0 1 "
      "0\"/></transform>\n</camera>\n"
      "<mesh type=\"sphere\"><bsdf type=\"mirrow\"/><emitter type=\"area\"><color name=\"radiance\" value=\"-1 0 "
      "0\"/></emitter></mesh>\n</scene>");
  EXPECT_EQ(parsed.diagnostics.error_count(), 7u) << all_messages(parsed.diagnostics);
}

TEST(SceneErrors, UnknownPropertyIsAWarningUnlessStrict) {
  const std::string text = in_camera("<float name=\"widht\" value=\"3\"/>");
  const Parsed lenient = parse(text);
  ASSERT_TRUE(lenient.file.has_value());
  ASSERT_EQ(lenient.diagnostics.list().size(), 1u);
  EXPECT_EQ(lenient.diagnostics.list()[0].severity, Severity::warning);
  EXPECT_EQ(to_string(lenient.diagnostics.list()[0]),
            "s.xml:3:14: <camera type=\"perspective\"> has no property \"widht\"; did you mean \"width\"?; it has: "
            "width, height, fov, fovAxis, focalLength, principalPointOffsetX, principalPointOffsetY, cropWidth, "
            "cropHeight, cropOffsetX, cropOffsetY, nearClip, farClip, path, dof, apertureRadius, focusDistance, "
            "toWorld; ignored");
  const Parsed strict = parse(text, {{}, true});
  EXPECT_FALSE(strict.file.has_value());
}

TEST(SceneErrors, HostileTextIsNotEchoed) {
  const Parsed parsed = parse(scene_around("<mesh type=\"&#x9b;2J" + std::string(1000, 'x') + "\"/>"));
  ASSERT_TRUE(parsed.diagnostics.has_errors());
  const std::string& message = parsed.diagnostics.list()[0].message;
  EXPECT_EQ(message.find("\xc2\x9b"), std::string::npos);
  EXPECT_LT(message.size(), 200u);
}

TEST(SceneErrors, AlbedoOutsideUnitRangeIsAWarning) {
  const Parsed parsed = parse(in_mesh("<bsdf type=\"diffuse\"><color name=\"albedo\" value=\"1.5 0.5 -0.5\"/></bsdf>"));
  ASSERT_TRUE(parsed.file.has_value()) << all_messages(parsed.diagnostics);
  EXPECT_NE(all_messages(parsed.diagnostics).find("3:50: albedo 1.5 is above 1"), std::string::npos)
      << all_messages(parsed.diagnostics);
  EXPECT_NE(all_messages(parsed.diagnostics).find("albedo -0.5 is below 0"), std::string::npos);
}

TEST(SceneErrors, MillionsOfProblemsStayQuickAndSmall) {
  std::string text = "<scene>";
  while (text.size() < (12u << 20)) text += "<difusematerials/>\n";
  text += "</scene>";
  const Parsed parsed = parse(text);
  EXPECT_FALSE(parsed.file.has_value());
  EXPECT_LE(parsed.diagnostics.list().size(), Diagnostics::kMaxListed + 1);
}

TEST(SceneErrors, MillionsOfAttributesStayLinear) {
  std::string text = "<scene><mesh type=\"obj\"";
  while (text.size() < (12u << 20)) text += " a=\"1\"";
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_FALSE(parse(text + "/></scene>").file.has_value());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(30));
}

TEST(SceneErrors, SizeLimitOfTheFile) {
  const Parsed parsed = parse(std::string((32u << 20) + 1, ' '));
  ASSERT_TRUE(parsed.diagnostics.has_errors());
  EXPECT_NE(parsed.diagnostics.list()[0].message.find("33554432 bytes"), std::string::npos);
}

struct BadFile {
  const char* what;
  std::string name;
  const char* says;
};

TEST(SceneErrors, FilesThatAreNotFiles) {
  TemporaryFolder folder;
  ASSERT_EQ(mkfifo(folder.path("fifo").c_str(), 0600), 0);
  const BadFile files[] = {{"missing", folder.path("none.xml"), "No such file"},
                           {"folder", folder.path(""), "this is a folder"},
                           {"fifo", folder.path("fifo"), "not a regular file"},
                           {"device", "/dev/zero", "not a regular file"}};
  for (const BadFile& file : files) {
    for (const bool as_mesh : {false, true}) {
      const std::string scene = folder.write(
          "scene.xml",
          scene_around("<mesh type=\"obj\"><string name=\"filename\" value=\"" + file.name + "\"/></mesh>"));
      try {
        read_scene(as_mesh ? scene : file.name);
        FAIL() << file.what;
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::scene) << file.what;
        EXPECT_NE(std::string(error.what()).find(file.says), std::string::npos) << error.what();
        const char* place = as_mesh ? "scene.xml:2:49: mesh " : "";
        EXPECT_NE(std::string(error.what()).find(place), std::string::npos) << error.what();
      }
    }
  }
}

TEST(SceneErrors, TestFileGivenToRenderNamesTheCommand) {
  TemporaryFolder folder;
  const std::string file = folder.write("t.xml", in_ttest("<string name=\"references\" value=\"1\"/>" + kMinimalScene));
  try {
    read_scene(file);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("etendue ttest"), std::string::npos) << error.what();
  }
}

TEST(SceneErrors, WhatIsLackingIsListedFirst) {
  const Parsed parsed = parse(
      "<scene><camera type=\"perspective\"/><integrator type=\"radiosity\"/>\n<mesh type=\"sphere\"><bsdf "
      "type=\"phong\"/></mesh>\n<mesh type=\"sphere\"><bsdf type=\"phong\"/></mesh>\n<medium "
      "type=\"homogeneous\"/><mesh type=\"marching_cubes\"/></scene>",
      {});
  EXPECT_FALSE(parsed.file.has_value());
  const std::string first = to_string(parsed.diagnostics.list().at(0));
  EXPECT_NE(first.find("bsdf phong (2:"), std::string::npos) << first;
  for (const char* part : {", 3:", "integrator radiosity (1:", "medium homogeneous (4:", "mesh marching_cubes (4:"})
    EXPECT_NE(first.find(part), std::string::npos) << part << " in " << first;
}

}  // namespace
}  // namespace etendue::testing
