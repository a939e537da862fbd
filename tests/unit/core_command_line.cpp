#include "core/command_line.h"

#include <algorithm>
#include <cstdint>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/terminal.h"

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
  const TerminalLog messages;
  Outcome outcome{.end = command.parse(static_cast<int>(arguments.size()), arguments.data())};
  outcome.out = testing::internal::GetCapturedStdout();
  outcome.err = testing::internal::GetCapturedStderr();
  return outcome;
}

// A program with one command that has an option of each kind.
struct Program {
  Command app{"does things", "program"};
  std::string file, word = "auto", report;
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
    go->add_option("FILE", file, "file to read")->required()->file({".xml"});
    go->add_option("-o,--output", outputs)->allow_extra_args(false)->type_name("OUT");
    go->add_option("--only", numbers)->delimiter(',');
    go->add_option("--seed", seed);
    go->add_option("--spp", spp)->check(positive());
    go->add_option("--level", level)->check(in_range(0.0, 1.0))->capture_default_str();
    go->add_option("--word", word)->check(one_of({"auto", "never"}));
    go->add_option("--secret", spp)->group("");
    go->add_optional_value("--json", report, "PATH", "report");
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

// The complaint about `program go scene WORDS`; nothing may have run.
std::string complaint(std::vector<std::string> words) {
  Program p;
  words.insert(words.begin(), {"go", "scene"});
  const Outcome outcome = parse(p.app, words);
  EXPECT_EQ(outcome.end, false);
  EXPECT_FALSE(p.ran);
  EXPECT_EQ(outcome.out, "");
  return outcome.err;
}

TEST(CommandLine, ChecksSayWhatWouldBeRight) {
  EXPECT_THAT(complaint({"--level", "2"}), HasSubstr("error: '--level 2' is out of range; write 0 to 1."));
  EXPECT_THAT(complaint({"--level", "high"}), HasSubstr("'--level high' is not a number."));
  EXPECT_THAT(complaint({"--spp", "0"}), HasSubstr("'--spp 0' is not above 0."));
  EXPECT_THAT(complaint({"--spp", "many"}), HasSubstr("'--spp many' is not a whole number."));
  EXPECT_THAT(complaint({"--spp", "1.5"}), HasSubstr("'--spp 1.5' is not a whole number."));
  EXPECT_THAT(complaint({"--spp", "-1"}), HasSubstr("'--spp -1' is out of range; write 0 to 4294967295."));
  EXPECT_THAT(complaint({"--only", "1,x"}), HasSubstr("'--only x' is not a whole number."));
  EXPECT_THAT(complaint({"--word", "sometimes"}), HasSubstr("'--word sometimes' is none of auto, never."));
  EXPECT_THAT(complaint({"--spp"}), HasSubstr("'--spp NUMBER' lacks its value."));
  EXPECT_THAT(complaint({"--quiet=very"}), HasSubstr("'--quiet' takes no value."));
  EXPECT_THAT(complaint({"--spp", "1", "--spp", "2"}), HasSubstr("'--spp' may be given only once."));
  EXPECT_THAT(complaint({"scene2"}), HasSubstr("'scene2' is one argument too many for 'program go'."));
}

TEST(CommandLine, GuessesWhatWasMeant) {
  Program p;
  EXPECT_THAT(parse(p.app, {"goo"}).err, HasSubstr("error: 'program' has no command 'goo'; did you mean \"go\"?"));
  Program far;
  EXPECT_THAT(parse(far.app, {"elephant"}).err, testing::Not(HasSubstr("did you mean")));
  EXPECT_THAT(complaint({"--outptu", "x"}),
              HasSubstr("'program go' has no option '--outptu'; did you mean \"--output\"?"));
  EXPECT_THAT(complaint({"--sede=4"}), HasSubstr("has no option '--sede'; did you mean \"--seed\"?"));
  EXPECT_THAT(complaint({"--word", "nevr"}), HasSubstr("did you mean \"never\"?"));
  EXPECT_THAT(complaint({"--secrt", "1"}), testing::Not(HasSubstr("--secret")));  // hidden options stay hidden
  EXPECT_THAT(complaint({"-x"}), HasSubstr("has no option '-x'. 'program go --help' tells more."));
}

TEST(CommandLine, AValueThatMayBeLeftOutStandsBehindTheSign) {
  const auto report_of = [](std::vector<std::string> words) {
    Program p;
    EXPECT_FALSE(parse(p.app, words).end.has_value()) << testing::PrintToString(words);
    EXPECT_EQ(p.file, "scene");
    return p.report;
  };
  EXPECT_EQ(report_of({"go", "scene"}), "");
  EXPECT_EQ(report_of({"go", "--json", "scene"}), "-");
  EXPECT_EQ(report_of({"go", "scene", "--json"}), "-");
  EXPECT_EQ(report_of({"go", "--json=r.json", "scene"}), "r.json");
  EXPECT_THAT(complaint({"--json", "r.json"}), HasSubstr("if it is the file to write, say --json=r.json."));
}

TEST(CommandLine, WantsACommandAndItsArguments) {
  Program none, no_file;
  EXPECT_THAT(parse(none.app, {}).err, HasSubstr("error: 'program' needs a command."));
  const Outcome outcome = parse(no_file.app, {"go"});
  EXPECT_EQ(outcome.end, false);
  EXPECT_THAT(outcome.err, HasSubstr("'program go' needs FILE: file to read."));
}

TEST(CommandLine, HelpAndVersionEndWell) {
  Program version, help, of_command;
  const Outcome text = parse(version.app, {"--version"});
  EXPECT_EQ(text.end, true);
  EXPECT_EQ(text.out, "program 1.2\n");
  const Outcome whole = parse(help.app, {"--help"});
  EXPECT_EQ(whole.end, true);
  EXPECT_THAT(whole.out, HasSubstr("program: does things\n"));
  EXPECT_THAT(whole.out, HasSubstr("The end."));
  const Outcome part = parse(of_command.app, {"go", "--help"});
  EXPECT_EQ(part.end, true);
  EXPECT_THAT(part.out, HasSubstr("OUT"));
  EXPECT_THAT(part.out, HasSubstr("0.5"));
  EXPECT_THAT(part.out, testing::Not(HasSubstr("--secret")));
}

TEST(CommandLine, HelpFitsIntoEightyColumns) {
  Program p;
  p.app.add_option("--long", p.word,
                   std::string(60, 'x') + " is, measured in characters such as × and …, " +
                       "what these many words have to be broken into lines for");
  std::istringstream lines(parse(p.app, {"--help"}).out);
  std::size_t longest = 0;
  for (std::string line; std::getline(lines, line);) {
    std::size_t width = 0;
    for (const char c : line) width += (static_cast<unsigned char>(c) & 0xc0) != 0x80;
    if (line.find("xxx") == std::string::npos) longest = std::max(longest, width);
  }
  EXPECT_LE(longest, 80u);
  EXPECT_GT(longest, 60u);
}

TEST(CommandLine, ManualPageEscapesWhatRoffWouldRead) {
  Program p;
  p.app.footer(".start of a line\na \\ and 'quotes'");
  const std::string page = parse(p.app, {"--man"}).out;
  EXPECT_THAT(page, HasSubstr(".TH PROGRAM 1 \"\" \"program 1.2\""));
  EXPECT_THAT(page, HasSubstr("\\fB\\-o\\fR, \\fB\\-\\-output\\fR \\fIOUT\\fR"));
  EXPECT_THAT(page, HasSubstr("\n\\&.start of a line\n"));
  EXPECT_THAT(page, HasSubstr("a \\e and \\(aqquotes\\(aq"));
  EXPECT_THAT(page, testing::Not(HasSubstr("secret")));
}

TEST(CommandLine, CompletionsNameEveryVisibleOption) {
  for (const char* shell : {"bash", "zsh", "fish"}) {
    Program p;
    const Outcome script = parse(p.app, {"--completion", shell});
    EXPECT_EQ(script.end, true);
    for (const char* name : {"output", "only", "seed", "spp", "level", "word", "quiet", "json", "version", "help"})
      EXPECT_THAT(script.out, HasSubstr(name)) << shell;
    EXPECT_THAT(script.out, testing::Not(HasSubstr("secret"))) << shell;
  }
  Program p;
  EXPECT_THAT(parse(p.app, {"--completion", "csh"}).err, HasSubstr("'--completion csh' is none of bash, zsh, fish"));
}

}  // namespace
}  // namespace etendue
