#include "apps/process/printable.hpp"

#include <catch2/catch.hpp>

using apps::printable;

TEST_CASE("plain text of any language passes as it is", "[apps][printable]") {
  CHECK(printable("Weg ÿ, 変位, \xF0\x9F\x93\x88 5 m/s²") == "Weg ÿ, 変位, \xF0\x9F\x93\x88 5 m/s²");
}

TEST_CASE("control characters, C1 codes and direction marks are escaped", "[apps][printable]") {
  CHECK(printable("\x1b[2Jx\n\r\x7f") == "\\x1b[2Jx\\x0a\\x0d\\x7f");
  CHECK(printable("\xC2\x9B") == "\\x9b");
  CHECK(printable("\xE2\x80\xAE") == "\\u{202e}");
  CHECK(printable(std::string_view("a\0b", 3)) == "a\\x00b");
}

TEST_CASE("bytes that are not UTF-8 become the replacement character", "[apps][printable]") {
  const std::string replaced = "\xEF\xBF\xBD";
  CHECK(printable("\xFF") == replaced);
  CHECK(printable("a\xC3") == "a" + replaced);
  CHECK(printable("\xC0\xAF") == replaced + replaced);                 // overlong '/'
  CHECK(printable("\xED\xA0\x80") == replaced + replaced + replaced);  // surrogate
}

TEST_CASE("a text keeps its lines and a JSON document its meaning", "[apps][printable]") {
  CHECK(apps::printable_lines("a\x1b[31m\n\xC2\x9B\n" + std::string(10'000, 'x')) ==
        "a\\x1b[31m\n\\x9b\n" + std::string(10'000, 'x'));
  CHECK(apps::printable_json("{\n \"a\": \"\x7f\xC2\x9B\xE2\x80\xAE\"\n}\n") ==
        "{\n \"a\": \"\\u007f\\u009b\\u202e\"\n}\n");
}

TEST_CASE("long text is cut", "[apps][printable]") {
  CHECK(printable(std::string(10'000, 'x'), 10) == "xxxxxxxxxx...");
}
