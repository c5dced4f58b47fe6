// SPDX-License-Identifier: MIT
// Python's view of the estimator's filter.
#pragma once
#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>

#if defined(__GLIBC__)
#include <malloc.h>
#endif
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "arrays.hpp"
#include "noise.hpp"
#include "seatrial/filter/growing_run.hpp"
#include "seatrial/filter/lookahead.hpp"
#include "seatrial/filter/noise_derivatives.hpp"
#include "seatrial/filter/smoother.hpp"
#include "series.hpp"

namespace {

using namespace seatrial;

FilterRun run_innovations(const Boat& boat, const ThrustTrace& trace, const Series& series,
                          Vector noise, double outlier, std::optional<Vector> effects,
                          std::optional<Vector> counts, std::optional<Places> blocks,
                          bool repeatable, bool shares, bool earth_fixed) {
  check_filter_trace(boat, trace);
  require(!counts || counts->shape(0) == series.time.size(), "counts: one for each pose");
  check_blocks(series, blocks);
  const NoiseParameters believed = make_noise(noise);
  Effects chosen = effects ? make_effects(*effects) : Effects{};
  chosen.earth_fixed = earth_fixed;
  const double* often = counts ? counts->data() : nullptr;
  nb::gil_scoped_release released;
  return innovations(boat, trace, series.poses, believed, outlier, series.start, chosen,
                     effects.has_value(), often, blocks ? blocks->data() : nullptr, repeatable,
                     shares);
}

std::unique_ptr<GrowingRun> make_growing_run(const Boat& boat, const ThrustTrace& trace,
                                             const Series& series, Vector noise, double outlier,
                                             std::optional<Vector> effects, bool earth_fixed) {
  check_filter_trace(boat, trace);
  Effects chosen = effects ? make_effects(*effects) : Effects{};
  chosen.earth_fixed = earth_fixed;
  return growing_run(boat, trace.columns(), make_noise(noise), outlier, series.start, chosen,
                     series.poses.position_delay, effects.has_value());
}

bool advance(GrowingRun& run, const ThrustTrace& trace, const Series& series, double until) {
  const int slopes = run.slopes() ? kEffects : 0;
  require(trace.columns().size() - kStates - kAxes + slopes == run.parameters(),
          "trace: the columns that the run began with");
  require(!run.begun() || series.time.front() <= run.time(),
          "series: poses from the run's time or before on");
  nb::gil_scoped_release released;
  return run.advance(trace, series.poses, until);
}

/// Checks what a repetition of a run needs, and gives the step of its parameters or null.
const double* step_of(const FilterRun& first, const Series& series,
                      const std::optional<Vector>& step) {
  const int updates = updates_of(first, series.poses);
  require(first.transition.size() + 1 == static_cast<std::size_t>(updates),
          "the poses of a first run that kept its transitions");
  if (!step) return nullptr;
  require(step->shape(0) == static_cast<std::size_t>(first.parameters), "step: one a parameter");
  return step->data();
}

/// Row i of noises (m, 11).
NoiseParameters make_noise(const Matrix& rows, std::size_t i) {
  require(rows.shape(1) == kNoiseParameters, "noises: 12 values in each row");
  return make_noise(rows.data() + i * kNoiseParameters);
}

inline std::tuple<double, Out1, Out2> run_noise_slopes(const FilterRun& first, const Series& series,
                                                       Vector noise, Matrix moved, Vector steps,
                                                       double outlier, std::optional<Vector> step,
                                                       bool slopes) {
  const double* by = step_of(first, series, step);
  const std::size_t m = steps.shape(0);
  require(moved.shape(0) == m && m <= kNoiseParameters, "moved: one row for each of the steps");
  const NoiseParameters here = make_noise(noise);
  std::vector<NoiseDirection> directions;
  for (std::size_t i = 0; i < m; ++i) directions.push_back({make_noise(moved, i), steps(i)});
  NoiseDerivatives found;
  {
    nb::gil_scoped_release released;
    found = noise_slopes(first, series.poses, here, directions, outlier, series.start, by, slopes);
  }
  return {found.cost, moved1(found.gradient), moved2(found.information, m)};
}

double run_repeated(const FilterRun& first, const Series& series, Vector noise, double outlier,
                    std::optional<Vector> step, bool slopes) {
  const double* by = step_of(first, series, step);
  const NoiseParameters other = make_noise(noise);
  nb::gil_scoped_release released;
  return repeated(first, series.poses, other, outlier, series.start, by, slopes);
}

FilterRun run_relinearised(const FilterRun& first, const Series& series, Vector noise,
                           double outlier, std::optional<Vector> step, bool slopes,
                           std::optional<Places> blocks) {
  const double* by = step_of(first, series, step);
  check_blocks(series, blocks);
  const NoiseParameters other = make_noise(noise);
  nb::gil_scoped_release released;
  return relinearised(first, series.poses, other, outlier, series.start, by, slopes,
                      blocks ? blocks->data() : nullptr);
}

std::tuple<Out2, Out2> run_smoothed(const FilterRun& first, const Series& series, Vector noise,
                                    double outlier) {
  step_of(first, series, std::nullopt);
  const NoiseParameters other = make_noise(noise);
  SmootherRun run;
  {
    nb::gil_scoped_release released;
    run = smoothed(first, series.poses, other, outlier, series.start);
  }
  return {moved2(run.state, kFilterStates), moved2(run.deviation, kAxes)};
}

Out2 run_lookahead_variance(const FilterRun& first, const Series& series, Vector noise,
                            double outlier, Places from, Places to, bool disturbed) {
  step_of(first, series, std::nullopt);
  require(from.shape(0) == to.shape(0), "from, to: one each for a prediction");
  const std::vector<int> begin(from.data(), from.data() + from.shape(0));
  const std::vector<int> end(to.data(), to.data() + to.shape(0));
  for (std::size_t i = 0; i < begin.size(); ++i) {
    require(begin[i] >= (i == 0 ? 0 : begin[i - 1]) && end[i] >= begin[i] &&
                static_cast<std::size_t>(end[i]) < series.time.size(),
            "from: rising poses; to: later ones");
  }
  const NoiseParameters other = make_noise(noise);
  std::vector<double> found;
  {
    nb::gil_scoped_release released;
    found = lookahead_variance(first, series.poses, other, outlier, series.start, begin, end,
                               disturbed);
  }
  return moved2(found, kAxes);
}

/// All that was kept pose by pose; sums stay.
void forget_poses(FilterRun& p) {
  std::vector<Transition>().swap(p.transition);
  for (auto* own : {&p.spread, &p.deviation, &p.weight, &p.gain}) std::vector<float>().swap(*own);
  for (auto* own : {&p.score, &p.innovation, &p.state, &p.update_state}) {
    std::vector<double>().swap(*own);
  }
}

/// Gives what was let go back to the system, where the C library keeps it scattered.
void give_back() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

void bind_filter(nb::module_& m) {
  using namespace nb::literals;
  nb::class_<FilterRun>(m, "FilterRun")
      .def_ro("good", &FilterRun::good)
      .def_ro("cost", &FilterRun::cost)
      .def_prop_ro("repeatable", [](const FilterRun& p) { return !p.transition.empty(); })
      .def("forget_transitions",
           [](FilterRun& p) {
             std::vector<Transition>().swap(p.transition);
             std::vector<float>().swap(p.gain);
             std::vector<double>().swap(p.update_state);
           })
      .def("forget_poses", &forget_poses)
      .def_prop_ro(
          "information",
          [](const FilterRun& p) {
            return moved2(p.information, static_cast<std::size_t>(p.parameters));
          },
          nb::for_getter(nb::rv_policy::move))
      .def_prop_ro(
          "gradient", [](const FilterRun& p) { return moved1(p.gradient); },
          nb::for_getter(nb::rv_policy::move))
      .def_prop_ro(
          "score",
          [](const FilterRun& p) {
            return moved2(p.score, static_cast<std::size_t>(p.parameters));
          },
          nb::for_getter(nb::rv_policy::move))
      .def_prop_ro(
          "share",
          [](const FilterRun& p) {
            return moved2(p.share, static_cast<std::size_t>(p.parameters));
          },
          nb::for_getter(nb::rv_policy::move))
      .def_prop_ro(
          "innovation", [](const FilterRun& p) { return moved2(p.innovation, kPose); },
          nb::for_getter(nb::rv_policy::move))
      .def_prop_ro(
          "spread", [](const FilterRun& p) { return moved2(p.spread, 6); },
          nb::for_getter(nb::rv_policy::move))
      .def_prop_ro(
          "state", [](const FilterRun& p) { return moved2(p.state, kFilterStates); },
          nb::for_getter(nb::rv_policy::move))
      .def_prop_ro(
          "deviation", [](const FilterRun& p) { return moved2(p.deviation, kAxes); },
          nb::for_getter(nb::rv_policy::move))
      .def_prop_ro(
          "weight", [](const FilterRun& p) { return moved1(p.weight); },
          nb::for_getter(nb::rv_policy::move));
  nb::class_<Series>(m, "Series")
      .def(
          nb::init<Vector, Matrix, Flags, Vector, Vector, std::optional<Matrix>, double,
                   std::optional<Flags>, std::optional<Asynchronous>, std::optional<InputErrors>>(),
          "time"_a, "eta"_a, "use"_a, "start"_a, "velocity"_a, "afresh"_a = nb::none(),
          "position_delay"_a = 0.0, "parts"_a = nb::none(), "asynchronous"_a = nb::none(),
          "input_errors"_a = nb::none());
  nb::class_<GrowingRun>(m, "GrowingRun", "A filter run along a recording that grows.")
      .def(nb::new_(&make_growing_run), "boat"_a, "trace"_a, "series"_a, "noise"_a, "outlier"_a,
           "effects"_a = nb::none(), "earth_fixed"_a = false)
      .def("advance", &advance, "trace"_a, "series"_a, "until"_a)
      .def("sums", &GrowingRun::sums)
      .def_prop_ro("good", &GrowingRun::good)
      .def_prop_ro("time", &GrowingRun::time)
      .def_prop_ro(
          "state",
          [](const GrowingRun& run) {
            const double* x = run.state();
            return moved1(std::vector<double>(x, x + kFilterStates));
          },
          nb::for_getter(nb::rv_policy::move));
  m.attr("EFFECTS") = kEffects;
  m.attr("POSITION_PART") = static_cast<int>(kPositionPart);
  m.attr("HEADING_PART") = static_cast<int>(kHeadingPart);
  m.attr("RATE_PART") = static_cast<int>(kRatePart);
  m.attr("NO_COLOUR") = kNoColour;
  m.attr("NO_TURN") = kNoTurn;
  m.attr("USE_JUMPED") = static_cast<int>(kJumped);
  m.attr("USE_GAPPED") = static_cast<int>(kGapped);
  m.attr("USE_BEGINNING") = static_cast<int>(kBeginning);
  m.def("give_back", &give_back);
  m.def("innovations", &run_innovations, "boat"_a, "trace"_a, "series"_a, "noise"_a, "outlier"_a,
        "effects"_a = nb::none(), "counts"_a = nb::none(), "blocks"_a = nb::none(),
        "repeatable"_a = true, "shares"_a = false, "earth_fixed"_a = false);
  m.def("noise_slopes", &run_noise_slopes, "first"_a, "series"_a, "noise"_a, "moved"_a, "steps"_a,
        "outlier"_a, "step"_a = nb::none(), "slopes"_a = false);
  m.def("repeated", &run_repeated, "first"_a, "series"_a, "noise"_a, "outlier"_a,
        "step"_a = nb::none(), "slopes"_a = false);
  m.def("relinearised", &run_relinearised, "first"_a, "series"_a, "noise"_a, "outlier"_a,
        "step"_a = nb::none(), "slopes"_a = false, "blocks"_a = nb::none());
  m.def("smoothed", &run_smoothed, "first"_a, "series"_a, "noise"_a, "outlier"_a,
        "States (n x 9) from the poses before and after each, and standard deviations (n x 3) of "
        "the velocity.");
  m.def("lookahead_variance", &run_lookahead_variance, "first"_a, "series"_a, "noise"_a,
        "outlier"_a, "from_pose"_a, "to_pose"_a, "disturbed"_a = false,
        "Variances (m x 3) of predictions that start from the filter, with or without its "
        "disturbance.");
}

}  // namespace
