#include "compare/python/keyword_options.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "compare/request/errors.h"
#include "compare/request/numbers.h"
#include "phase/parameters/parameters.h"

namespace lamella {

namespace py = pybind11;

namespace {

std::string text_of(const py::handle& value) { return py::cast<std::string>(py::str(value)); }

[[noreturn]] void refuse(const std::string& option, const py::handle& found,
                         const std::string& allowed) {
  throw UsageError(fmt::format("{}: found \"{}\"; allowed: {}", option, text_of(found), allowed));
}

double number_of(const std::string& option, const py::handle& value, const std::string& allowed) {
  // NumPy's numbers are numbers, too; a bool or a text is none.
  if (PyBool_Check(value.ptr()) || PyUnicode_Check(value.ptr())) refuse(option, value, allowed);
  const double number = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred()) {
    PyErr_Clear();
    refuse(option, value, allowed);
  }
  return number;
}

double positive(const std::string& option, const py::handle& value) {
  const char* const allowed = "a number in (0, inf)";
  const double number = number_of(option, value, allowed);
  if (!(number > 0) || !std::isfinite(number)) refuse(option, value, allowed);
  return number;
}

std::uint64_t whole(const std::string& option, const py::handle& value, std::uint64_t from,
                    std::uint64_t to) {
  const std::string allowed = fmt::format("a whole number from {} to {}", from, to);
  // A float such as 1e6 is taken, too; a long integer keeps its digits.
  const std::string text =
      PyFloat_Check(value.ptr()) ? fmt::format("{:.17g}", py::cast<double>(value)) : text_of(value);
  const auto number = parse_whole_number(text);
  if (!number || *number < from || *number > to) refuse(option, value, allowed);
  return *number;
}

// "THETA" or "THETA,PHI" with every digit.
std::string angle_text(const py::handle& entry) {
  const char* const allowed = "THETA or (THETA, PHI) in degrees";
  if (!py::isinstance<py::sequence>(entry)) return to_text(number_of("--wi", entry, allowed));
  const auto pair = py::reinterpret_borrow<py::sequence>(entry);
  if (PyUnicode_Check(entry.ptr()) || pair.size() < 1 || pair.size() > 2)
    refuse("--wi", entry, allowed);
  std::string text;
  for (const py::handle& part : pair)
    text += (text.empty() ? "" : ",") + to_text(number_of("--wi", part, allowed));
  return text;
}

std::string grid_text(const py::handle& value) {
  const char* const allowed = "(MU, PHI), such as (16, 32), each from 1 to 4096";
  if (!py::isinstance<py::sequence>(value) || PyUnicode_Check(value.ptr()))
    refuse("--grid", value, allowed);
  const auto pair = py::reinterpret_borrow<py::sequence>(value);
  if (pair.size() != 2) refuse("--grid", value, allowed);
  return text_of(pair[0]) + "x" + text_of(pair[1]);
}

}  // namespace

Options options_of(const py::dict& keywords) {
  Options options;
  for (const auto& [key, value] : keywords) {
    const std::string name = text_of(key);
    if (name == "wi") {
      for (const py::handle& entry : py::reinterpret_borrow<py::sequence>(value))
        options.incident.push_back(angle_text(entry));
      if (options.incident.empty()) refuse("--wi", value, "one direction or more");
    } else if (name == "distribution") {
      options.incident_law = text_of(value);
    } else if (name == "walks") {
      options.walks = whole("--walks", value, kBatches, 1000000000000000);
      options.walks_given = true;
    } else if (name == "target_error") {
      options.target_error = positive("--target-error", value);
    } else if (name == "time") {
      options.seconds = positive("--time", value);
    } else if (name == "max_order") {
      options.max_order = whole("--max-order", value, 1, std::uint64_t{1} << 62);
    } else if (name == "thin_from") {
      const std::uint64_t from = whole("--thin-from", value, 0, 1 << 20);
      if ((from & (from - 1)) != 0)
        refuse("--thin-from", value, fmt::format("0, or a power of two up to {}", 1 << 20));
      options.thin_from = static_cast<std::uint32_t>(from);
    } else if (name == "walk_order_1") {
      options.walk_order_1 = py::cast<bool>(value);
    } else if (name == "sampling") {
      options.sampling = to_text(parse_sampling(text_of(value)));
    } else if (name == "tolerance") {
      options.tolerance = positive("--tolerance", value);
    } else if (name == "grid") {
      options.grid = grid_text(value);
    } else if (name == "estimator") {
      options.estimator = text_of(value);
    } else if (name == "seed") {
      options.seed = whole("--seed", value, 0, std::numeric_limits<std::uint64_t>::max());
    } else if (name == "threads") {
      options.threads = static_cast<int>(whole("--threads", value, 1, 4096));
    } else if (name == "isa") {
      options.isa = text_of(value);
    } else if (name == "quick") {
      options.quick = py::cast<bool>(value);
    } else if (name == "as_is") {
      options.as_is = py::cast<bool>(value);
    } else if (name == "max_error") {
      options.max_error = positive("--max-error", value);
    } else {
      throw UsageError(fmt::format("keyword \"{}\": unknown", name));
    }
  }
  // In the order in which messages name them.
  if (options.walks_given) options.walk_settings.push_back(WalkSetting::walks);
  if (options.target_error) options.walk_settings.push_back(WalkSetting::target_error);
  if (options.max_order) options.walk_settings.push_back(WalkSetting::max_order);
  if (options.thin_from) options.walk_settings.push_back(WalkSetting::thin_from);
  if (options.seconds) options.walk_settings.push_back(WalkSetting::seconds);
  return options;
}

}  // namespace lamella
