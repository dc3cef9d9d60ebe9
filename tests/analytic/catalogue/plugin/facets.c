/* A rough dielectric's reflection (GGX, Smith's height-correlated shadowing, Fresnel) over EON with
 * exact albedo, as renderers write them: in the number type REAL, with 1 - cosine, clamps and an
 * approximate square root's epsilon left in. Built once in float and once in double, so that the
 * one can be held against the other. Walter et al. 2007; Portsmouth, Kutz and Hill 2025. */
#include <math.h>
#include <stdlib.h>

#include "analytic/catalogue/lamella_model.h"

typedef REAL real;

#define PI ((real)3.14159265358979323846)

typedef struct {
  real albedo[3], roughness, alpha, f0;
} state_t;

static void* create(const double* v) {
  state_t* s = malloc(sizeof *s);
  if (!s) return NULL;
  for (int c = 0; c < 3; ++c) s->albedo[c] = (real)v[c];
  s->roughness = (real)v[3];
  s->alpha = (real)v[4];
  s->f0 = (real)v[5];
  return s;
}

static real clamp01(real x) { return x < 0 ? 0 : x > 1 ? 1 : x; }

static real smith_lambda(real mu, real a2) {
  const real tangent2 = (1 - mu * mu) / (mu * mu);
  return ((real)-1 + (real)sqrt((real)(1 + a2 * tangent2))) / 2;
}

static real fon_albedo(real mu, real r) {
  const real a = 1 / (1 + ((real)0.5 - 2 / (3 * PI)) * r), b = r * a;
  const real s = (real)sqrt((real)(1 - mu * mu));
  const real g = s * ((real)acos((double)mu) - s * mu) +
                 ((real)2 / 3) * ((s / mu) * (1 - s * s * s) - s);
  return a + b / PI * g;
}

static void eval_one(const state_t* s, const double* wi_, const double* wo_, double* f, double* d) {
  real i[3], o[3], h[3];
  for (int k = 0; k < 3; ++k) i[k] = (real)wi_[k], o[k] = (real)wo_[k];
  for (int c = 0; c < 3; ++c) f[c] = d[c] = 0;
  const real least = (real)1e-6;
  if (i[2] < 0 || o[2] < 0) return;
  const real mu_i = i[2] > least ? i[2] : least, mu_o = o[2] > least ? o[2] : least;
  for (int k = 0; k < 3; ++k) h[k] = i[k] + o[k];
  const real length = (real)sqrt((real)(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]));
  const real n = length > 0 ? h[2] / length : 1;
  const real cosine = clamp01((i[0] * h[0] + i[1] * h[1] + i[2] * h[2]) / length);
  const real a2 = s->alpha * s->alpha, q = n * n * (a2 - 1) + 1;
  const real ndf = a2 / (PI * q * q);
  const real shadowing = 1 / (1 + smith_lambda(mu_i, a2) + smith_lambda(mu_o, a2));
  const real miss = 1 - cosine, miss2 = miss * miss;
  const real fresnel = s->f0 + (1 - s->f0) * miss2 * miss2 * miss;
  const real facet = ndf * shadowing * fresnel / (4 * mu_i * mu_o);

  const real r = s->roughness, a = 1 / (1 + ((real)0.5 - 2 / (3 * PI)) * r);
  const real sines = i[0] * o[0] + i[1] * o[1];
  const real t = sines > 0 ? (mu_i > mu_o ? mu_i : mu_o) : 1;
  const real ei = fon_albedo(mu_i, r), eo = fon_albedo(mu_o, r);
  const real mean = a * (1 + ((real)2 / 3 - 28 / (15 * PI)) * r);
  for (int c = 0; c < 3; ++c) {
    const real rho = s->albedo[c];
    const real twice = rho * rho * mean / (1 - rho * (1 - mean));
    const real single = rho / PI * a * (1 + r * sines / t);
    const real ms = twice / PI * (1 - ei) * (1 - eo) / (1 - mean > least ? 1 - mean : least);
    f[c] = facet;
    d[c] = single + (ms > 0 ? ms : 0);
  }
}

static void eval(void* state, size_t count, const double* wi, const double* wo, double* values) {
  for (size_t k = 0; k < count; ++k)
    eval_one(state, wi + 3 * k, wo + 3 * k, values + 3 * k, values + 3 * (count + k));
}

static const lamella_parameter_v1_t parameters[] = {
    {"albedo", "1", "of the diffuse part", 0.8, 0, 1, 3},
    {"roughness", "1", "of the diffuse part", 0.5, 0, 1, 1},
    {"alpha", "1", "of the facets", 0.3, 0.001, 1, 1},
    {"reflectance", "1", "of the facets at normal incidence; 0: no facets but Fresnel's rise", 0.04,
     0, 1, 1}};
static const lamella_lobe_v1_t lobes[] = {{"facets", "GGX", 0}, {"diffuse", "EON", 0}};

const lamella_model_v1_t lamella_model_v1 = {.version = LAMELLA_MODEL_V1,
                                             .name = "facets",
                                             .doc = "GGX over EON",
                                             .source = "tests",
                                             .parameter_count = 4,
                                             .parameters = parameters,
                                             .lobe_count = 2,
                                             .lobes = lobes,
                                             .reciprocal = 1,
                                             .transmits = 0,
                                             .create = create,
                                             .destroy = free,
                                             .eval = eval};
