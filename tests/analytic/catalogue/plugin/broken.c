/* Objects that must be refused; BROKEN says how. */
#include <math.h>

#include "analytic/catalogue/lamella_model.h"

#define NO_SYMBOL 1
#define WRONG_VERSION 2
#define NO_EVAL 3
#define NOT_A_NUMBER 4
#define NEGATIVE 5
#define SILENT 6

static void eval(void* state, size_t count, const double* wi, const double* wo, double* values) {
  (void)state, (void)wi, (void)wo;
#if BROKEN != SILENT
  for (size_t k = 0; k < 3 * count; ++k) values[k] = BROKEN == NOT_A_NUMBER ? NAN : -0.25;
#else
  (void)count, (void)values;
#endif
}

static const lamella_lobe_v1_t lobes[] = {{"diffuse", "", 0}};

#if BROKEN == NO_SYMBOL
const lamella_model_v1_t another_name = {
#else
const lamella_model_v1_t lamella_model_v1 = {
#endif
    .version = BROKEN == WRONG_VERSION ? 7 : LAMELLA_MODEL_V1,
    .name = "broken",
    .lobe_count = 1,
    .lobes = lobes,
#if BROKEN != NO_EVAL
    .eval = eval,
#endif
};
