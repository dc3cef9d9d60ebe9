#include "analytic/half_space/vmf_sigma_fit.h"

#include "phase/medium/vmf.h"

namespace lamella {

VmfSmoothSigma::VmfSmoothSigma(double a) : alpha(a), tanh(std::tanh(1 / (a * a))) {}

VmfMiddleSigma::VmfMiddleSigma(double alpha) {
  const double a = std::max(0.0, alpha - 0.1), b2 = (1 - alpha) * (1 - alpha), b4 = b2 * b2;
  p1 = 0.4975 - 0.273731 * std::pow(a, 1.7);
  p2 = 0.153918 - 0.139522 * std::pow(a, 1.2);
  p4 = 0.013762 + (0.013922 * alpha - 0.027553) * alpha;
  p8 = 0.048357 * b4;
  wave = 0.033493 * b4;
}

VmfRoughSigma::VmfRoughSigma(double alpha) {
  const double kappa = vmf_concentration(alpha);
  const double cosine = vmf_mean_cosine(kappa);
  // 1 - 3 cosine / kappa, the second Legendre moment of D
  const double k2 = kappa * kappa;
  const double moment =
      kappa < 0.05 ? k2 / 15 * (1 - 2 * k2 / 21 + k2 * k2 / 105) : 1 - 3 * cosine / kappa;
  mean = cosine / 2;
  second = 5.0 / 32 * moment;
}

VmfSigmaFit::VmfSigmaFit(double alpha)
    : range(alpha < 0.25  ? Range::smooth
            : alpha < 0.9 ? Range::middle
                          : Range::rough),
      smooth(alpha),
      middle(alpha),
      rough(alpha) {}

double vmf_sigma_fit_smooth(double u, double alpha) { return VmfSmoothSigma(alpha)(u); }
double vmf_sigma_fit_middle(double u, double alpha) { return VmfMiddleSigma(alpha)(u); }
double vmf_sigma_fit_rough(double u, double alpha) { return VmfRoughSigma(alpha)(u); }
double vmf_sigma_fit(double u, double alpha) { return VmfSigmaFit(alpha)(u); }

}  // namespace lamella
