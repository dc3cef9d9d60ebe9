#pragma once

#include <memory>
#include <vector>

#include "analytic/layered/single_scattering_model.h"
#include "compare/reproduce/reproduction.h"

namespace lamella {

/// Orders 2 and up of a stack of layers without a substrate, of any symmetry, tabulated by walks on
/// cells of both directions: 8 x 16 per hemisphere. Values are means over cells, linear between
/// their middles.
class CellTable {
 public:
  /// `walks`: per direction of w_o, of which there are 256.
  CellTable(const Stack& stack, std::uint64_t walks, const ReproductionContext& context);

  [[nodiscard]] Rgb operator()(Direction wi, Direction wo) const;

 private:
  [[nodiscard]] Rgb cell(int view, bool below, int row, int column) const;

  std::vector<Rgb> values_;  // by direction of w_o, side of w_i, cell
};

/// A stack turned about the normal: order 1 exactly, the rest by the table of the stack as it was.
class TabulatedStack final : public Model {
 public:
  /// `turned`: the stack turned by `angle` [radians], counter-clockwise seen from above.
  TabulatedStack(const Stack& turned, double angle, std::shared_ptr<const CellTable> table)
      : Model(1), first_(turned), angle_(angle), table_(std::move(table)) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override;
  [[nodiscard]] Rgb eval(Direction wi, Direction wo) const override { return eval_lobe(0, wi, wo); }
  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override {
    return first_.sample(wo, u1, u2, u3);
  }
  [[nodiscard]] double pdf(Direction wi, Direction wo) const override { return first_.pdf(wi, wo); }
  [[nodiscard]] double uncollided(Direction wi) const override { return first_.uncollided(wi); }

 private:
  SingleScatteringModel first_;
  double angle_;
  std::shared_ptr<const CellTable> table_;
};

}  // namespace lamella
