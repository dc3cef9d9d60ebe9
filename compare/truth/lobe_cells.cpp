#include "compare/truth/lobe_cells.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace lamella {
namespace {

constexpr int kRings = 4, kSectors = 8;  // cells to begin with
constexpr int kDeepest = 40;             // halvings of a cell, of one side or of both
constexpr int kMostHalved = 400;         // cells that are halved for their error

double largest(Rgb c) { return std::max({std::abs(c.r), std::abs(c.g), std::abs(c.b)}); }

struct CellNode {
  double r0, r1, phi0, phi1;
  int level = 0;
  Rgb value{}, halved{};  // by its own points, and by those of its quarters
  int first_child = -1, children = 0;
  [[nodiscard]] double error() const { return largest(halved - value); }
  [[nodiscard]] double radial() const { return r1 - r0; }
  [[nodiscard]] double tangential() const { return (phi1 - phi0) * (r0 + r1) / 2; }
};

class LobeTree {
 public:
  LobeTree(const std::function<Rgb(Direction)>& f, double mu_o) : f_(f) {
    for (int i = 0; i < kRings; ++i)
      for (int j = 0; j < kSectors; ++j)
        add(static_cast<double>(i) / kRings, (i + 1.0) / kRings, kPi * j / kSectors,
            kPi * (j + 1) / kSectors, 0);
    roots_ = static_cast<int>(nodes_.size());
    const double radius = std::sqrt(std::max(1 - mu_o, 0.0));
    for (int root = 0; root < roots_; ++root)
      for (const double phi : {kPi, 0.0}) seed(root, radius, phi, kSeedShare * mu_o);
  }

  // Halves the cell with the largest error until all errors together are small enough.
  [[nodiscard]] bool refine() {
    const auto less = [&](int a, int b) {
      const double x = nodes_[a].error(), y = nodes_[b].error();
      return x < y || (x == y && a > b);
    };
    std::priority_queue<int, std::vector<int>, decltype(less)> open(less);
    double error = 0, energy = 0;
    const auto count = [&](int k) {
      open.push(k);
      error += nodes_[k].error();
      energy += largest(nodes_[k].halved);
    };
    for (int k = 0; k < static_cast<int>(nodes_.size()); ++k)
      if (nodes_[k].children == 0) count(k);
    for (int halved = 0; error > kLobeTolerance * energy; ++halved) {
      const int k = open.top();
      if (halved == kMostHalved || nodes_[k].level >= kDeepest) return false;
      open.pop();
      error -= nodes_[k].error();
      energy -= largest(nodes_[k].halved);
      halve(k);
      for (int c = 0; c < nodes_[k].children; ++c) count(nodes_[k].first_child + c);
    }
    return true;
  }

  [[nodiscard]] LobeCells cells() {
    LobeCells result;
    for (int root = 0; root < roots_; ++root) result.energy += sum(root);
    result.energy = 2 * result.energy;
    // A cell is kept whole, though parts of it were halved, where that changed nothing to speak of.
    const double most = kLobeTolerance * largest(result.energy) / 64;
    for (int root = 0; root < roots_; ++root) collect(root, most, result.cells);
    return result;
  }

 private:
  [[nodiscard]] Rgb at(double r, double phi) const {
    const Direction wi = from_lambert_disc({r * std::cos(phi), r * std::sin(phi)});
    return wi.z * f_(wi);
  }

  // Integral over a rectangle by 2 x 2 points of Gauss-Legendre; dw = 2 r dr dphi.
  [[nodiscard]] Rgb integral(double r0, double r1, double phi0, double phi1) const {
    static const double half = 0.5 / std::sqrt(3.0);
    Rgb total;
    for (const double s : {0.5 - half, 0.5 + half})
      for (const double t : {0.5 - half, 0.5 + half}) {
        const double r = r0 + s * (r1 - r0);
        total += r * at(r, phi0 + t * (phi1 - phi0));
      }
    return 2 * (r1 - r0) * (phi1 - phi0) / 4 * total;
  }

  void add(double r0, double r1, double phi0, double phi1, int level) {
    CellNode n{r0, r1, phi0, phi1, level};
    n.value = integral(r0, r1, phi0, phi1);
    const double r = (r0 + r1) / 2, phi = (phi0 + phi1) / 2;
    n.halved = integral(r0, r, phi0, phi) + integral(r, r1, phi0, phi) +
               integral(r0, r, phi, phi1) + integral(r, r1, phi, phi1);
    nodes_.push_back(n);
  }

  // Along the longer side, or both where they are nearly equal.
  void halve(int k) {
    const CellNode n = nodes_[k];
    const int first = static_cast<int>(nodes_.size());
    const double r = (n.r0 + n.r1) / 2, phi = (n.phi0 + n.phi1) / 2;
    if (n.radial() > 1.5 * n.tangential()) {
      add(n.r0, r, n.phi0, n.phi1, n.level + 1);
      add(r, n.r1, n.phi0, n.phi1, n.level + 1);
    } else if (n.tangential() > 1.5 * n.radial()) {
      add(n.r0, n.r1, n.phi0, phi, n.level + 1);
      add(n.r0, n.r1, phi, n.phi1, n.level + 1);
    } else {
      add(n.r0, r, n.phi0, phi, n.level + 2);
      add(r, n.r1, n.phi0, phi, n.level + 2);
      add(n.r0, r, phi, n.phi1, n.level + 2);
      add(r, n.r1, phi, n.phi1, n.level + 2);
    }
    nodes_[k].first_child = first;
    nodes_[k].children = static_cast<int>(nodes_.size()) - first;
  }

  // Halves what lies about a place until it is as small as `least`, ever smaller towards it.
  void seed(int k, double r, double phi, double least) {
    const CellNode n = nodes_[k];
    const double size = std::max(n.radial(), n.tangential());
    if (size <= least || n.level >= kDeepest) return;
    const double away_r = std::max({n.r0 - r, r - n.r1, 0.0});
    const double away_phi = r * std::max({n.phi0 - phi, phi - n.phi1, 0.0});
    if (std::max(away_r, away_phi) > 0.25 * size) return;
    if (n.children == 0) halve(k);
    for (int c = 0; c < nodes_[k].children; ++c) seed(nodes_[k].first_child + c, r, phi, least);
  }

  [[nodiscard]] Rgb sum(int k) const {
    const CellNode& n = nodes_[k];
    if (n.children == 0) return n.halved;
    Rgb total;
    for (int c = 0; c < n.children; ++c) total += sum(n.first_child + c);
    return total;
  }

  [[nodiscard]] bool is_smooth(int k, double most) const {
    const CellNode& n = nodes_[k];
    if (n.error() > most) return false;
    for (int c = 0; c < n.children; ++c)
      if (!is_smooth(n.first_child + c, most)) return false;
    return true;
  }

  void collect(int k, double most, std::vector<LobeCells::Cell>& cells) const {
    const CellNode& n = nodes_[k];
    if (n.children == 0 || is_smooth(k, most)) {
      const double r = (n.r0 + n.r1) / 2, phi = (n.phi0 + n.phi1) / 2;
      const Direction wi = from_lambert_disc({r * std::cos(phi), r * std::sin(phi)});
      const auto cosines = [](double q) {
        return q - q * q / 2;
      };  // integral of mu_i, q = radius^2
      const Rgb middle = (n.phi1 - n.phi0) * (cosines(n.r1 * n.r1) - cosines(n.r0 * n.r0)) * f_(wi);
      cells.push_back({r * std::cos(phi), r * std::sin(phi), std::max(n.radial(), n.tangential()),
                       largest(middle - sum(k))});
      return;
    }
    for (int c = 0; c < n.children; ++c) collect(n.first_child + c, most, cells);
  }

  const std::function<Rgb(Direction)>& f_;
  std::vector<CellNode> nodes_;
  int roots_ = 0;
};

}  // namespace

DiscPoint on_lambert_disc(Direction w) {
  // sqrt(2) sin(theta / 2) / sin(theta)
  const double scale = 1 / std::sqrt(1 + std::max(w.z, 0.0));
  return {scale * w.x, scale * w.y};
}

Direction from_lambert_disc(DiscPoint p) {
  const double q = p.x * p.x + p.y * p.y, scale = std::sqrt(std::max(2 - q, 0.0));
  return {scale * p.x, scale * p.y, 1 - q};
}

LobeCells lobe_cells(const std::function<Rgb(Direction wi)>& f, double mu_o) {
  LobeTree tree(f, mu_o);
  const bool resolved = tree.refine();
  LobeCells cells = tree.cells();
  cells.resolved = resolved;
  return cells;
}

}  // namespace lamella
