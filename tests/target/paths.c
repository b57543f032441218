/* davar tests - links the start, the path of a sample of both number types, with every window law,
 * and the evaluation of a result, for the tests that read the disassembly. It runs and does
 * nothing. */
#include "board.h"

#include "davar/cascade.h"
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/glr.h"

int main(void)
{
    static const davar_law_t *const laws[] = {&davar_law_kurtosis, &davar_law_or, &davar_law_and,
                                              &davar_law_glr_q15, &davar_law_glr_q31};
    static davar_t davar;
    static davar_cascade_t cascade;
    static davar_result_t result;
    static davar_plan_t plan;
    const int16_t narrow = 0;
    const int32_t wide = 0;
    char command[8];
    davar_config_t config = davar_default_config;
    board_command_line(command, sizeof command);
    if (command[0] == '\0') {
        config.law = laws[(unsigned char)command[1] % (sizeof laws / sizeof laws[0])];
        if ((davar_init_q15(&davar, &config, NULL, 0U) != DAVAR_OK) ||
            (davar_init_q31(&davar, &config, NULL, 0U) != DAVAR_OK)) {
            return 1;
        }
        davar_plan_init(&plan, NULL, 0U);
        davar_plan_init_filtered(&plan, NULL, 0U, NULL);
        davar_push_q15(&davar, &narrow, 1U);
        davar_push_q31(&davar, &wide, 1U);
        davar_cascade_push_q15(&cascade, &narrow, 1U);
        davar_cascade_push_q31(&cascade, &wide, 1U);
        (void)davar_take(&davar, &result);
        davar_fit(&plan, 1.0, &result);
    }
    return 0;
}
