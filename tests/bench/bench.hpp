#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

// Each adds benchmarks of CPU time, named by what they do: "fast_rvm/duffing". Tables and files that they need are made
// or read when first asked for. google-benchmark adds to the names how the time was taken: process_time by itself,
// manual_time where children count too (`add`), which is then its real_time.

namespace bench {

/// What the processor and its memory can do: multiply-adds of one core, and reading.
void register_machine();
/// Of each problem NAME in this folder (NAME_Phi.npy, rows x terms, and NAME_T.npy, rows x outputs): the R factor, the
/// same on one and on two threads by the clock, and the whole fit of all outputs by each relevance vector machine; from
/// NAME_X.npy, rows x 3, the products up to degree 3 of three states, read from the file and folded block by block.
/// Nothing where the folder is empty or not there.
void register_fits(const std::filesystem::path& problems);
/// Every subset of 13 and of 20 terms.
void register_rankings();
/// A spectral derivative of 44,032 samples, and the records of the paper's Duffing and Coulomb cases.
void register_signals();
/// What a run does to each raw sample, a bare read of the same file, and soxr; `folder` is for their files.
void register_raw_part(const std::filesystem::path& folder);
/// `ardent run` on 1800 s of the rig's raw record, with a bare read and the hash of the same file beside it.
void register_whole_run(const std::filesystem::path& ardent, const std::filesystem::path& folder);

/// What nobody can go below who reads through libsndfile: every sample as a double, and nothing done with it.
void bare_read(const std::filesystem::path& file);
/// What `ardent run` does with a raw file until it has 256 samples a second.
void raw_part(const std::filesystem::path& file);
/// Figures of a benchmark beside its time.
using Figures = std::vector<std::pair<std::string, double>>;
/// Registers one whose time is CPU time, user and system, of this process and its children; wall_ms beside it, and what
/// `figures` says afterwards.
void add(const std::string& name, const std::function<void()>& work, const std::function<Figures()>& figures = {});

}  // namespace bench
