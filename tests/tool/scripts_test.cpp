// Scripts that others rely on: figures between marks in a document, and the check of the code's format.
#include <doctest/doctest.h>
#include <sys/wait.h>

#include <cstdlib>

#include "tests/support/support.h"

using namespace nephele::test;

namespace {

// Exit status of a bash command in the source directory; what it says goes to the file "said".
int run_bash(const TempDirectory& directory, const std::string& command) {
  write_file(directory / "command", command);
  const std::string line = std::string("cd '") + NEPHELE_SOURCE_DIR + "' && bash '" + directory / "command" + "' >'" +
                           directory / "said" + "' 2>&1 </dev/null";
  const int status = std::system(line.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

const std::string kDocument =
    "# Title\nby hand\n<!-- figures: a b -->\nold\nolder\n<!-- end: a b -->\nmore by hand\n"
    "<!-- figures: c -->\n<!-- end: c -->\nlast";

}  // namespace

TEST_CASE("marked blocks: the lines between the marks are replaced, all others stay byte for byte") {
  const TempDirectory directory;
  const std::string document = directory / "document.md";
  const auto replace = [&](const std::string& arguments) {
    return run_bash(directory,
                    "set -euo pipefail\nsource tools/marked_block.sh\nfirst_fails() { echo some; false; echo "
                    "more; }\nmarked_block '" +
                        document + "' " + arguments + "\n");
  };
  write_file(document, kDocument);
  CHECK(replace("'a b' printf '%s\\n' one '| two |' 'a & b \\1'") == 0);
  CHECK(replace("c echo last figure") == 0);
  CHECK(read_file(document) ==
        "# Title\nby hand\n<!-- figures: a b -->\none\n| two |\na & b \\1\n<!-- end: a b -->\nmore by hand\n"
        "<!-- figures: c -->\nlast figure\n<!-- end: c -->\nlast");
  CHECK(directory.entries() == std::vector<std::string>{"command", "document.md", "said"});
}

TEST_CASE("marked blocks: nothing changes where marks are missing or doubled, or the figures' command fails") {
  const TempDirectory directory;
  const std::string document = directory / "document.md";
  const auto refuse = [&](const std::string& text, const std::string& arguments, int status) {
    CAPTURE(text);
    CAPTURE(arguments);
    write_file(document, text);
    CHECK(run_bash(directory,
                   "set -euo pipefail\nsource tools/marked_block.sh\nhalf() { echo some; false; echo more; }\n"
                   "marked_block '" +
                       document + "' " + arguments + "\n") == status);
    CHECK(read_file(document) == text);
    CHECK(directory.entries() == std::vector<std::string>{"command", "document.md", "said"});
  };
  refuse(kDocument, "unknown echo x", 2);
  refuse(kDocument, "a echo x", 2);  // the beginning of a name is no name
  refuse("<!-- figures: a -->\n", "a echo x", 2);
  refuse("<!-- end: a -->\n", "a echo x", 2);
  refuse("<!-- end: a -->\n<!-- figures: a -->\n", "a echo x", 2);
  refuse("<!-- figures: a -->\n<!-- figures: a -->\n<!-- end: a -->\n", "a echo x", 2);
  refuse(kDocument, "c true", 2);  // no figures at all
  refuse(kDocument, "c half", 1);  // some figures, then a failure
  refuse(kDocument, "c exit 3", 3);
  CHECK(run_bash(directory, "source tools/marked_block.sh\nmarked_block '" + directory / "none.md" + "' c echo x") ==
        2);
}

TEST_CASE("format: long lines and unformatted code are named, in files that are given") {
  const TempDirectory directory;
  const auto check = [&](const std::string& name, const std::string& text) {
    write_file(directory / name, text);
    return run_bash(directory, "tools/check_format.sh '" + directory / name + "'");
  };
  const std::string columns_120 = "# " + std::string(118, 'x') + "\n";
  CHECK(check("good.sh", columns_120) == 0);
  CHECK(check("bad.sh", "# x\n#" + columns_120) == 1);
  CHECK(read_file(directory / "said").find("bad.sh:2:") != std::string::npos);
  CHECK(check("wide.cmake", "# " + std::string(118 - 1, 'x') + "\xc3\x97\n") == 0);  // two bytes, one column
  CHECK(check("text.md", "#" + columns_120) == 0);                                   // prose may be as wide as it likes
  CHECK(check("good.cpp", "int main() {}\n") == 0);
  if (run_bash(directory, "clang-format --version | grep -q 'version 14'") == 0)
    CHECK(check("bad.cpp", "int main( ) {}\n") == 1);
}
