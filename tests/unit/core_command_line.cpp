#include "core/command_line.h"

#include <cstdint>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct Outcome {
  std::optional<bool> end;
  std::string out, err;
};

Outcome parse(Command& command, std::vector<std::string> words) {
  words.insert(words.begin(), "program");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Outcome outcome{.end = command.parse(static_cast<int>(arguments.size()), arguments.data())};
  outcome.out = testing::internal::GetCapturedStdout();
  outcome.err = testing::internal::GetCapturedStderr();
  return outcome;
}

// A program with one command that has an option of each kind.
struct Program {
  Command app{"Does things.", "program"};
  std::string file, word = "auto";
  std::vector<std::string> outputs;
  std::vector<std::uint32_t> numbers;
  std::optional<std::uint64_t> seed;
  std::uint32_t spp = 0;
  double level = 0.5;
  bool quiet = false, ran = false;

  Program() {
    app.set_version_flag("program 1.2");
    app.require_subcommand();
    app.footer("The end.");
    Command* go = app.add_subcommand("go", "goes");
    go->add_option("FILE", file, "file to read")->required();
    go->add_option("-o,--output", outputs)->allow_extra_args(false)->type_name("OUT");
    go->add_option("--only", numbers)->delimiter(',');
    go->add_option("--seed", seed);
    go->add_option("--spp", spp)->check(positive());
    go->add_option("--level", level)->check(in_range(0.0, 1.0))->capture_default_str();
    go->add_option("--word", word)->check(one_of({"auto", "never"}));
    go->add_option("--secret", spp)->group("");
    go->add_flag("-q,--quiet", quiet);
    go->callback([this] { ran = true; });
  }
};

TEST(CommandLine, ReadsOptionsOfEveryKind) {
  Program p;
  EXPECT_FALSE(parse(p.app, {"go", "-o", "a", "-o", "b", "scene", "--only", "1,2", "--seed", "7", "--spp", "3", "-q"})
                   .end.has_value());
  EXPECT_TRUE(p.ran);
  EXPECT_EQ(p.file, "scene");
  EXPECT_THAT(p.outputs, ElementsAre("a", "b"));
  EXPECT_THAT(p.numbers, ElementsAre(1u, 2u));
  EXPECT_EQ(p.seed, 7u);
  EXPECT_EQ(p.spp, 3u);
  EXPECT_TRUE(p.quiet);
}

TEST(CommandLine, ChecksSayWhatWouldBeRight) {
  const auto complaint = [](std::vector<std::string> words) {
    Program p;
    words.insert(words.begin(), {"go", "scene"});
    const Outcome outcome = parse(p.app, words);
    EXPECT_EQ(outcome.end, false);
    EXPECT_FALSE(p.ran);
    return outcome.err;
  };
  EXPECT_THAT(complaint({"--level", "2"}), HasSubstr("--level: Value 2 not in range"));
  EXPECT_THAT(complaint({"--spp", "0"}), HasSubstr("--spp"));
  EXPECT_THAT(complaint({"--spp", "many"}), HasSubstr("--spp"));
  EXPECT_THAT(complaint({"--word", "sometimes"}), HasSubstr("auto,never"));
  EXPECT_THAT(complaint({"--unknown"}), HasSubstr("--unknown"));
}

TEST(CommandLine, WantsACommandAndItsArguments) {
  Program none, no_file;
  EXPECT_EQ(parse(none.app, {}).end, false);
  const Outcome outcome = parse(no_file.app, {"go"});
  EXPECT_EQ(outcome.end, false);
  EXPECT_THAT(outcome.err, HasSubstr("FILE is required"));
}

TEST(CommandLine, HelpAndVersionEndWell) {
  Program version, help, of_command;
  const Outcome text = parse(version.app, {"--version"});
  EXPECT_EQ(text.end, true);
  EXPECT_EQ(text.out, "program 1.2\n");
  const Outcome whole = parse(help.app, {"--help"});
  EXPECT_EQ(whole.end, true);
  EXPECT_THAT(whole.out, HasSubstr("Does things."));
  EXPECT_THAT(whole.out, HasSubstr("The end."));
  const Outcome part = parse(of_command.app, {"go", "--help"});
  EXPECT_EQ(part.end, true);
  EXPECT_THAT(part.out, HasSubstr("OUT"));
  EXPECT_THAT(part.out, HasSubstr("0.5"));
  EXPECT_THAT(part.out, testing::Not(HasSubstr("--secret")));
}

}  // namespace
}  // namespace etendue
