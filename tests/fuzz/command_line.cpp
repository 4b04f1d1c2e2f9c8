// The command line, an argument a line, in a folder of small recordings. Only commands that read, and init, which
// writes into that folder.
#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>

#include "fuzz/harness.hpp"
#include "fuzz/program.hpp"
#include "support/scratch.hpp"

namespace {

constexpr std::array left_out{"run", "batch", "prep", "study", "sim", "frc", "replicate", "manual"};

/// No command that computes for long, and no way out of the folder.
bool is_harmless(const std::string& argument) {
  return argument.find('/') == std::string::npos && argument.find("..") == std::string::npos &&
         std::find(left_out.begin(), left_out.end(), argument) == left_out.end();
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  return {"info\na.csv\n--json",
          "info\na.csv\nb.csv\n--salvage\n--strict\n-v",
          "check\na.csv\n--set\nlibrary.order=1\n--uncalibrated\n--max-memory\n10",
          "check\na.toml\n--set=range.0.name=all\n--json\n--threads=2",
          "terms\n--json",
          "fit\na.csv\n--target\na\n--terms\n1,x,v,abs(x)*v\n--methods\nols,fast_rvm\n--where\nv>0",
          "fit\na.csv\n--target=a\n--terms=terms.txt\n--methods=sindy,ridge,lasso\n--threshold=0.1\n--tau=2\n-q",
          "init\na.csv\n-o\n.\n--force",
          "init\nb.csv\n-obelow\n--json",
          "compare\nx\ny\n--method\nols",
          "--version",
          "fit\n--help"};
}

void fuzz::run(const std::string& input) {
  std::vector<std::string> arguments;
  std::istringstream lines(input);
  for (std::string line; std::getline(lines, line);) {
    line.erase(std::min(line.find('\0'), line.size()));  // as the system would hand it over
    if (!is_harmless(line)) return;
    arguments.push_back(line);
  }
  const support::Scratch scratch;
  const WorkingFolder here(scratch / "");
  scratch.file("a.csv", small_record());
  scratch.file("b.csv", "t,x\n0,1\n1,2\n2,4\n3,1\n");
  scratch.file("a.toml", "[[recording]]\nfile = \"a.csv\"\n[library]\norder = 1\nterms = [\"sgn(v)\"]\n");
  scratch.file("terms.txt", "x  # spring\nv\n1\n");
  run_program(arguments);
}
