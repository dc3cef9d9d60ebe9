/* A model of one's own: Minnaert's law, f = albedo (k + 1) / (2 pi) (mu_i mu_o)^(k - 1).
 *
 *     cc -shared -fPIC -I PREFIX/include/lamella minnaert.c -lm -o minnaert.so
 *     lamella compare lambert_sphere_halfspace --model ./minnaert.so,k=0.9,albedo=0.8
 */
#include <math.h>
#include <stdlib.h>

#include "analytic/catalogue/lamella_model.h"

#define PI 3.14159265358979323846

typedef struct {
  double albedo[3], k;
} Minnaert;

static void* create(const double* values) {
  Minnaert* m = malloc(sizeof *m);
  if (!m) return NULL;
  for (int c = 0; c < 3; ++c) m->albedo[c] = values[c];
  m->k = values[3];
  return m;
}

static void eval(void* state, size_t count, const double* wi, const double* wo, double* values) {
  const Minnaert* m = state;
  for (size_t j = 0; j < count; ++j) {
    const double mu_i = wi[3 * j + 2], mu_o = wo[3 * j + 2];
    const double f =
        mu_i > 0 && mu_o > 0 ? (m->k + 1) / (2 * PI) * pow(mu_i * mu_o, m->k - 1) : 0;
    for (int c = 0; c < 3; ++c) values[3 * j + c] = m->albedo[c] * f;
  }
}

/* w_i from mu^k d(mu): for every w_o the law has the same shape. */
static int sample(void* state, const double* wo, const double* u, double* wi) {
  const Minnaert* m = state;
  if (wo[2] < 0) return 0;
  const double mu = pow(u[0], 1 / (m->k + 1)), s = sqrt((1 - mu) * (1 + mu)), phi = 2 * PI * u[1];
  wi[0] = s * cos(phi);
  wi[1] = s * sin(phi);
  wi[2] = mu;
  return 1;
}

static double pdf(void* state, const double* wi, const double* wo) {
  const Minnaert* m = state;
  return wo[2] < 0 || wi[2] < 0 ? 0 : (m->k + 1) / (2 * PI) * pow(wi[2], m->k);
}

static const lamella_parameter_v1_t parameters[] = {
    {"albedo", "1", "scale", 1, 0, 1, 3},
    {"k", "1", "1: Lambert; below: brighter towards grazing", 0.9, 0.5, 1, 1},
};
static const lamella_lobe_v1_t lobes[] = {{"diffuse", "all of it", 0}};

const lamella_model_v1_t lamella_model_v1 = {
    LAMELLA_MODEL_V1,
    "minnaert",
    "Minnaert's law",
    "Minnaert 1941, The reciprocity principle in lunar photometry",
    2,
    parameters,
    1,
    lobes,
    1, /* reciprocal */
    0, /* transmits */
    create,
    free,
    eval,
    sample,
    pdf,
};
