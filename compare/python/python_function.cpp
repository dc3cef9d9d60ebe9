#include "compare/python/python_function.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "analytic/model/batched_model.h"
#include "compare/python/arrays.h"

namespace lamella {

namespace py = pybind11;

namespace {

std::string shape_text(const py::array& array) {
  std::string text;
  for (py::ssize_t k = 0; k < array.ndim(); ++k)
    text += fmt::format("{}{}", k ? ", " : "", array.shape(k));
  return "(" + text + ")";
}

std::string vector_text(Direction w) { return fmt::format("[{}, {}, {}]", w.x, w.y, w.z); }

// Calls the function and looks at the shape of what comes back; the lock is held.
Doubles1 call(const std::string& name, const py::object& function, std::span<const Direction> wi,
              std::span<const Direction> wo) {
  const py::object given = function(array_of(wi), array_of(wo));
  const Doubles1 result = Doubles1::ensure(given);
  if (!result) {
    PyErr_Clear();
    throw std::invalid_argument(
        fmt::format("{}: found what is no array of numbers; allowed: values of f, shape (n,), "
                    "(n, 1) or (n, 3)",
                    name));
  }
  const auto n = static_cast<py::ssize_t>(wi.size());
  const bool flat = result.ndim() == 1 && result.shape(0) == n;
  const bool colors =
      result.ndim() == 2 && result.shape(0) == n && (result.shape(1) == 1 || result.shape(1) == 3);
  if (!flat && !colors)
    throw std::invalid_argument(
        fmt::format("{}: found an array of shape {} for {} pairs; allowed: ({},), ({}, 1) or "
                    "({}, 3)",
                    name, shape_text(result), n, n, n, n));
  return result;
}

class FunctionModel : public BatchedModel {
 public:
  FunctionModel(std::string name, py::object function, bool transmits)
      : name_(std::move(name)), function_(std::move(function)), transmits_(transmits) {}
  ~FunctionModel() override {
    const py::gil_scoped_acquire acquire;
    function_ = py::object();
  }
  FunctionModel(const FunctionModel&) = delete;
  FunctionModel& operator=(const FunctionModel&) = delete;

  using BatchedModel::eval;
  void eval(std::span<const DirectionPair> pairs, std::span<Rgb> values,
            Isa /*isa*/) const override {
    if (pairs.empty()) return;
    std::vector<Direction> wi, wo;
    std::vector<std::size_t> places;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      values[k] = Rgb();
      if (!transmits_ && (pairs[k].wi.z < 0) != (pairs[k].wo.z < 0)) continue;
      wi.push_back(pairs[k].wi);
      wo.push_back(pairs[k].wo);
      places.push_back(k);
    }
    if (places.empty()) return;
    const py::gil_scoped_acquire acquire;
    const Doubles1 result = call(name_, function_, wi, wo);
    const double* numbers = result.data();
    const bool grey = result.size() == static_cast<py::ssize_t>(places.size());
    for (std::size_t k = 0; k < places.size(); ++k) {
      Rgb& value = values[places[k]];
      value = grey ? Rgb(numbers[k]) : Rgb(numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]);
      for (int c = 0; c < 3; ++c)
        if (!(value[c] >= 0) || std::isinf(value[c]))
          throw std::domain_error(
              fmt::format("{}: found {} at w_i = {}, w_o = {}; allowed: finite values, not below 0",
                          name_, value[c], vector_text(wi[k]), vector_text(wo[k])));
    }
  }

 private:
  std::string name_;
  py::object function_;
  bool transmits_;
};

}  // namespace

ModelInfo function_info(const std::string& name, bool transmits) {
  ModelInfo info;
  info.name = name;
  info.doc = "a Python function";
  info.source = "Python";
  info.lobes = {{"f", "the function's values", Order::all}};
  info.reciprocal = false;
  info.transmits = transmits;
  return info;
}

std::unique_ptr<Model> function_model(const std::string& name, py::object function,
                                      bool transmits) {
  return std::make_unique<FunctionModel>(name, std::move(function), transmits);
}

int channels_of_function(const std::string& name, const py::object& function) {
  const Direction wi = direction_from_degrees(30, 0), wo = direction_from_degrees(20, 50);
  return call(name, function, {&wi, 1}, {&wo, 1}).size() == 1 ? 1 : 3;
}

}  // namespace lamella
