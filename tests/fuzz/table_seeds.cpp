#include <fmt/format.h>

#include "fuzz/harness.hpp"

std::vector<std::string> fuzz::seeds() {
  std::string gap = "t,x,v\n";  // one cell of forty may be empty or no number
  for (int i = 0; i < 40; ++i)
    gap += fmt::format("{:.1f},{},{}\n", 0.1 * i, i == 9 ? "NaN" : "1.5", i == 20 ? "" : "-2e-3");
  return {gap, "# rig 3\nTime (ms);x_mm;ddr [m/s^2]\n0,0;1,5;2\n10,0;1,25;3\n20,0;7;4\n30,0;1,75;5\n",
          "\xef\xbb\xbf\"time\"\t\"a b\"\r\n1e-3\t1\r\n2e-3\t2\r\n3e-3\t3\r\n", "1 2 3\n4 5 6\n7 8 9",
          "t,f\n0,1\n0.5,2\n1,3\n2,4\n2.5,3\n3,3\n"};
}
