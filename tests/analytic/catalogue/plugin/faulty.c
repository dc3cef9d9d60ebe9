/* Lambert's law with a uniform sampler, and one fault per `kind`: what a check of it must find. */
#include <math.h>
#include <stdlib.h>

#include "analytic/catalogue/lamella_model.h"

#define PI 3.14159265358979323846

enum { RIGHT, ONE_WAY, GAINS, DENSITY_TWICE, OTHER_SAMPLES, HALF_UNSEEN, OTHER_BATCHES, PASSES };

static void* create(const double* v) {
  int* kind = malloc(sizeof *kind);
  if (kind) *kind = (int)v[0];
  return kind;
}

static void eval(void* state, size_t count, const double* wi, const double* wo, double* values) {
  const int kind = *(const int*)state;
  for (size_t k = 0; k < count; ++k) {
    const double mu_i = wi[3 * k + 2], mu_o = wo[3 * k + 2];
    double f = mu_i > 0 && mu_o > 0 ? 0.8 / PI : 0;
    if (kind == ONE_WAY) f *= 1 + 1e-5 * mu_i;
    if (kind == GAINS) f *= 1.26;
    if (kind == OTHER_BATCHES && k % 8 == 7) f *= 1 + 1e-12;
    if (kind == PASSES && mu_i > 0 && mu_o < 0) f = 0.1 / PI;
    for (int c = 0; c < 3; ++c) values[3 * k + c] = f;
  }
}

static int sample(void* state, const double* wo, const double* u, double* wi) {
  const int kind = *(const int*)state;
  if (wo[2] < 0) return 0;
  /* Cosines that are too large. */
  const double mu = kind == OTHER_SAMPLES ? pow(u[0], 0.8) : u[0], s = sqrt((1 - mu) * (1 + mu));
  const double phi = (kind == HALF_UNSEEN ? PI : 2 * PI) * u[1];
  wi[0] = s * cos(phi);
  wi[1] = s * sin(phi);
  wi[2] = mu;
  return 1;
}

static double pdf(void* state, const double* wi, const double* wo) {
  const int kind = *(const int*)state;
  if (wo[2] < 0 || wi[2] < 0) return 0;
  if (kind == HALF_UNSEEN) return wi[1] >= 0 ? 1 / PI : 0;
  return (kind == DENSITY_TWICE ? 2 : 1) / (2 * PI);
}

static const lamella_parameter_v1_t parameters[] = {
    {"kind", "1", "which fault; 0: none", 0, 0, 7, 1}};
static const lamella_lobe_v1_t lobes[] = {{"all", "all of it", 0}};

const lamella_model_v1_t lamella_model_v1 = {.version = LAMELLA_MODEL_V1,
                                             .name = "faulty",
                                             .doc = "one fault each",
                                             .source = "tests",
                                             .parameter_count = 1,
                                             .parameters = parameters,
                                             .lobe_count = 1,
                                             .lobes = lobes,
                                             .reciprocal = 1,
                                             .transmits = 0,
                                             .create = create,
                                             .destroy = free,
                                             .eval = eval,
                                             .sample = sample,
                                             .pdf = pdf};
