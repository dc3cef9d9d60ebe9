/* The interface of a model of your own: a shared object that `lamella --model ./mine.so` loads and
 * judges like any built-in closed form. C99 and C++; depends on nothing.
 *
 * The object exports one constant of this type under this name:
 *
 *     const lamella_model_v1_t lamella_model_v1 = {.version = LAMELLA_MODEL_V1, ...};
 *
 * Directions are unit, point away from the surface, z up: three doubles x, y, z; z is never 0 in
 * eval, 1e-150 stands for its limit from above (0 in single precision: clamp it before a division).
 * Values are f [1/sr],
 * the BSDF without the cosine, three doubles r, g, b. Every function may be called from several
 * threads at once. All strings are UTF-8, one line, and live as long as the object. */
#ifndef LAMELLA_MODEL_H
#define LAMELLA_MODEL_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LAMELLA_MODEL_V1 1u

/* The scattering order a lobe stands for: 1, 2, 3, 4 (four and more), or 0 (all). */
typedef struct {
  const char* name; /* of the lobe; [a-z0-9_]+ */
  const char* doc;
  int order;
} lamella_lobe_v1_t;

typedef struct {
  const char* name; /* [a-z0-9_]+; "albedo" and "f0" are set to 1 by a white furnace */
  const char* unit; /* "1": dimensionless */
  const char* doc;
  double default_value, min, max; /* min <= default <= max */
  int channels;                   /* 1: a number; 3: a colour */
} lamella_parameter_v1_t;

typedef struct {
  uint32_t version; /* LAMELLA_MODEL_V1 */
  const char* name; /* [a-z0-9_]+ */
  const char* doc;
  const char* source; /* where the model is from */
  uint32_t parameter_count;
  const lamella_parameter_v1_t* parameters;
  uint32_t lobe_count; /* at least 1 */
  const lamella_lobe_v1_t* lobes;
  int reciprocal; /* f(w_i, w_o) = f(w_o, w_i) is claimed */
  int transmits;  /* has values where w_i and w_o lie on different sides */

  /* A model with fixed parameters: their values in order, three for a colour. Optional: without it,
   * `state` is NULL below. NULL from it refuses the parameters. */
  void* (*create)(const double* values);
  void (*destroy)(void* state);

  /* values[3 (count lobe + k) + c]: lobe `lobe` at pair k, channel c; w_i at wi[3 k], w_o at
   * wo[3 k]. Finite and not negative. */
  void (*eval)(void* state, size_t count, const double* wi, const double* wo, double* values);

  /* Optional, both or none: w_i given w_o from three uniforms in (0, 1), 0 if there is none; and
   * the density [1/sr] of that. Without them, the cosine law. */
  int (*sample)(void* state, const double* wo, const double* uniforms, double* wi);
  double (*pdf)(void* state, const double* wi, const double* wo);
} lamella_model_v1_t;

#ifdef __cplusplus
}
#endif

#endif
