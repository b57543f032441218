/* davar tests - links the path of a sample of both number types and the evaluation of a result, for
 * the test that reads the disassembly. It can run, but does nothing. */
#include "board.h"

#include "davar/davar.h"

int main(void)
{
    static davar_t davar;
    static davar_result_t result;
    static davar_plan_t plan;
    const int16_t narrow = 0;
    const int32_t wide = 0;
    char command[8];
    board_command_line(command, sizeof command);
    if (command[0] == '\0') {
        davar_push_q15(&davar, &narrow, 1U);
        davar_push_q31(&davar, &wide, 1U);
        (void)davar_take(&davar, &result);
        davar_fit(&plan, 1.0, &result);
    }
    return 0;
}
