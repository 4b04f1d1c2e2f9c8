#include "fuzz/harness.hpp"
#include "support/tdms.hpp"

using support::Tdms;

std::vector<std::string> fuzz::seeds() {
  std::vector<std::string> all;
  const std::vector<double> values{0.0, 1.0, 3.0, 2.0, 5.0, 4.0, 7.0, 6.0, 9.0, 8.0, 1.0, 0.0};
  const std::string texts("\x02\0\0\0\x04\0\0\0upin", 12);
  for (const bool is_big : {false, true}) {
    const Tdms tdms{is_big};
    const std::vector<std::string> clock{tdms.property("wf_increment", 0.004), tdms.start(3'800'000'000, 0.5),
                                         tdms.property("unit_string", "mm")};
    const std::vector<std::string> scale{tdms.property("NI_Scale[1]_Scale_Type", "Polynomial"),
                                         tdms.property("NI_Scale[1]_Polynomial_Coefficients[0]", 1),
                                         tdms.property("NI_Scale[1]_Polynomial_Coefficients[1]", 2.0),
                                         tdms.property("NI_Scale[1]_Polynomial_Input_Source", 0.0),
                                         tdms.property("wf_increment", 0.004)};
    const std::vector<std::string> objects{tdms.object("/", tdms.none()), tdms.object("/'g'", tdms.none()),
                                           tdms.object("/'g'/'x'", tdms.index(Tdms::i16, values.size()), clock),
                                           tdms.object("/'g'/'y'", tdms.index(Tdms::f64, values.size()), scale)};
    const std::string chunk = tdms.values(Tdms::i16, values) + tdms.values(Tdms::f64, values);
    all.push_back(tdms.segment(Tdms::new_list, objects, chunk + chunk) + tdms.segment(0, {}, chunk));
    all.push_back(tdms.segment(Tdms::new_list | Tdms::interleaved, objects, chunk) +
                  tdms.segment(0, {tdms.object("/'g'/'x'", tdms.same())}, chunk));
    all.push_back(tdms.segment(
        Tdms::new_list,
        {tdms.object("/'g'/'Time'", tdms.index(Tdms::time, values.size())),
         tdms.object("/'g'/'x'", tdms.index(Tdms::f32, values.size())),
         tdms.object("/'g'/'words'", tdms.text_index(2, texts.size()))},
        tdms.values(Tdms::time, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}) + tdms.values(Tdms::f32, values) + texts));
  }
  return all;
}
