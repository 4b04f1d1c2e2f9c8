#include "dsp/values/signals.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <string>

TEST_CASE("every role has one line in the table of signals, under one name", "[dsp][signals]") {
  std::set<std::string_view> names;
  std::set<dsp::Role> roles;
  for (const dsp::SignalInfo& signal : dsp::signal_table()) {
    names.insert(signal.name);
    roles.insert(signal.role);
    CHECK(&dsp::info_of(signal.role) == &signal);
    CHECK(dsp::find_signal(signal.name) == &signal);
    CHECK_FALSE(signal.meaning.empty());
    CHECK((signal.order >= 0) == (signal.body != dsp::Body::none));
  }
  CHECK(names.size() == dsp::signal_table().size());
  CHECK(roles.size() == dsp::signal_table().size());
}

TEST_CASE("each body has a displacement, its velocity and its acceleration", "[dsp][signals]") {
  for (const dsp::Body body : {dsp::Body::base, dsp::Body::payload, dsp::Body::relative}) {
    const dsp::SignalInfo& velocity = dsp::motion_signal(body, 1);
    CHECK(dsp::derivative_of(dsp::motion_signal(body, 0).name) == &velocity);
    CHECK(dsp::derivative_of(velocity.name) == &dsp::motion_signal(body, 2));
    CHECK(dsp::derivative_of(dsp::motion_signal(body, 2).name) == nullptr);
  }
  for (const char* name : {"f", "t", "payload"}) CHECK(dsp::derivative_of(name) == nullptr);
}
