// README, tutorial and the other documents show what commands print: tests/document_outputs.py runs them.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "support/program.hpp"

using support::Scratch;

namespace {

bool no_python(const Scratch& folder) {
  if (support::run(folder, "command -v python3").code == 0) return false;
  WARN("skipped: no python3");
  return true;
}

support::Ended outputs(const Scratch& folder, const std::string& arguments) {
  return support::run(folder, "python3 '" ARDENT_SOURCES "/tests/document_outputs.py' \"$ARDENT\" " + arguments);
}

}  // namespace

TEST_CASE("documents show what their commands print", "[apps][documents]") {
  const Scratch folder;
  if (no_python(folder)) return;
  for (const char* document : {"README.md", "docs/tutorial.md", "docs/method.md", "docs/validation.md"}) {
    const auto ended = outputs(folder, std::string("'" ARDENT_SOURCES "/") + document + "'");
    INFO(ended.err);
    CHECK(ended.code == 0);
  }
}

TEST_CASE("an output that a document does not show is found, and written into it", "[apps][documents]") {
  const Scratch folder;
  if (no_python(folder)) return;
  const std::string command = "Words.\n\n    $ printf 'a = 1.2345(6) x^3\\n12 s,\\n3 rows\\n\\nleft out\\nend\\n'\n";
  const auto code = [&](const std::string& shown) {
    (void)folder.file("a.md", command + shown);
    return outputs(folder, "a.md").code;
  };
  for (const char* same : {"    a = 1.2345(6) x^3\n    12 s,\n    3 rows\n    ...\n    end\n\nMore.\n",
                           "    a = 1.2355(7) x^3\n    ...\n    3 rows\n    ...\n", "    ...\n    end\n", "    ...\n",
                           "    a = 1.2345(6)\n    x^3 13 s, 3 rows\n\n    left out end\n"}) {
    CAPTURE(same);
    CHECK(code(same) == 0);
  }
  for (const char* other :
       {"    a = 1.2366(6) x^3\n    ...\n", "    a = 1.2345(8) x^3\n    ...\n", "    a = 1.2345 x^3\n    ...\n",
        "    a = 1.2345(6) x^2\n    ...\n", "    a = -1.2345(6) x^3\n    ...\n", "    ...\n    14 s,\n    ...\n",
        "    ...\n    4 rows\n    ...\n", "    b = 1.2345(6) x^3\n    ...\n", "    ...\n    left out\n",
        "    a = 1.2345(6) x^3\n", "    ...\n    3 rows\n    ...\n    12 s,\n    ...\n", ""}) {
    CAPTURE(other);
    CHECK(code(other) == 1);
  }
  CHECK(code("    a = 1.3(1) x^3\n    ...\n    8 rows\n    ...\n\nMore.\n") == 1);
  CHECK(outputs(folder, "--write a.md").code == 1);
  CHECK(support::bytes_of(folder / "a.md") ==
        command + "    a = 1.2345(6) x^3\n    ...\n    3 rows\n    ...\n\nMore.\n");
  CHECK(outputs(folder, "a.md").code == 0);
  (void)folder.file("a.md", "    $ exit 3\n");
  CHECK(outputs(folder, "a.md").code == 1);
}
