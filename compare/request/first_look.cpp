#include "compare/request/first_look.h"

#include <fmt/format.h>

#include <algorithm>

namespace lamella {

FirstLook::FirstLook(const TruthRequest& request, std::size_t runs, double seconds,
                     std::uint64_t default_walks)
    : effort_(request.effort), left_(runs), seconds_(seconds) {
  has_clock_ = !effort_.seconds && !effort_.target_error && effort_.walks == default_walks &&
               std::find(request.given.begin(), request.given.end(), WalkSetting::walks) ==
                   request.given.end();
}

StopRule FirstLook::next() {
  StopRule rule = effort_;
  if (!has_clock_) return rule;
  if (!start_) start_ = Clock::now();
  const double spent = std::chrono::duration<double>(Clock::now() - *start_).count();
  // A run that comes late still gets a moment.
  rule.seconds = std::max(seconds_ - spent, 0.05 * seconds_) /
                 static_cast<double>(std::max<std::size_t>(left_, 1));
  if (left_ > 0) --left_;
  return rule;
}

std::string first_look_text(const std::string& label, std::uint64_t walks, const StopRule& rule) {
  return fmt::format("{}: {} of {} walks in {:.2g} s; --walks or --time for more", label, walks,
                     rule.walks, rule.seconds.value_or(0));
}

}  // namespace lamella
