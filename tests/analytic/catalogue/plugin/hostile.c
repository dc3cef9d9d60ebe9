/* Models that adaptive quadratures have to survive, by the parameter `kind`. Each is finite and not
 * negative unless it says otherwise; where the directional albedo is known it stands beside it. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "analytic/catalogue/lamella_model.h"

static void* create(const double* v) {
  int* kind = malloc(sizeof *kind);
  if (kind) *kind = (int)v[0];
  return kind;
}

/* In [0, 1), a hash of the direction's bits: noise that no two neighbours share. */
static double hashed(const double* w) {
  uint64_t x = 0x9e3779b97f4a7c15u;
  for (int k = 0; k < 3; ++k) {
    uint64_t bits;
    memcpy(&bits, w + k, sizeof bits);
    x = (x ^ bits) * 0xbf58476d1ce4e5b9u;
    x ^= x >> 29;
  }
  return (double)(x >> 11) * 0x1p-53;
}

static double value(int kind, const double* wi, const double* wo) {
  const double pi = 3.14159265358979323846;
  if (wi[2] < 0 || wo[2] < 0) return 0;
  switch (kind) {
    case 0: /* noise of 10 %: albedo 1 */
      return (1 + 0.1 * (2 * hashed(wo) - 1)) / pi;
    case 1: /* a hard shadow's edge across the hemisphere, x = 0.3 z: albedo 1/2 + 0.3 / (2 sqrt(1.09)) */
      return wo[0] < 0.3 * wo[2] ? 1 / pi : 0;
    case 2: /* grows at grazing until no integral exists */
      return 1e-3 / (wo[2] * wo[2]);
    case 3: /* without bound at grazing, yet integrable: albedo 1 */
      return 0.625 / pi * pow(wo[2], -0.75);
    case 4: /* not a number next to grazing */
      return wo[2] < 0.01 ? NAN : 1 / pi;
    case 5: /* below 0 next to grazing */
      return wo[2] < 0.01 ? -1 : 1 / pi;
    case 6: /* so large that sums overflow */
      return 1e308;
    case 7: { /* a checkerboard of 1000 fields: albedo near 1/2 */
      const int field = (int)floor(500 * wo[0]) + (int)floor(500 * wo[1]);
      return field % 2 ? 1 / pi : 0;
    }
    case 8: { /* a millisecond per value */
      const struct timespec nap = {0, 1000000};
      nanosleep(&nap, NULL);
      return wo[0] < 0.3 * wo[2] ? 1 / pi : 0;
    }
    default: /* a spike of 1e-7 about the normal: albedo 1 of a Gaussian in x and y */
      return exp(-(wo[0] * wo[0] + wo[1] * wo[1]) * 1e14) * 1e14 / pi;
  }
}

static void eval(void* state, size_t count, const double* wi, const double* wo, double* values) {
  for (size_t k = 0; k < count; ++k) {
    const double f = value(*(const int*)state, wi + 3 * k, wo + 3 * k);
    for (int c = 0; c < 3; ++c) values[3 * k + c] = f;
  }
}

static const lamella_parameter_v1_t parameters[] = {
    {"kind", "1", "which", 0, 0, 9, 1}};
static const lamella_lobe_v1_t lobes[] = {{"all", "all of it", 0}};

const lamella_model_v1_t lamella_model_v1 = {.version = LAMELLA_MODEL_V1,
                                             .name = "hostile",
                                             .doc = "values that quadratures have to survive",
                                             .source = "tests",
                                             .parameter_count = 1,
                                             .parameters = parameters,
                                             .lobe_count = 1,
                                             .lobes = lobes,
                                             .reciprocal = 0,
                                             .transmits = 0,
                                             .create = create,
                                             .destroy = free,
                                             .eval = eval};
