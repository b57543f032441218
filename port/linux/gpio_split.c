/* davar for Linux - CHIP:LINE. */
#include "gpio.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool gpio_split(const char *text, char *chip, size_t size, unsigned *line)
{
    const char *colon = strrchr(text, ':');
    if ((colon == NULL) || (colon == text) || ((size_t)(colon - text) >= size) ||
        (colon[1] == '\0') || (strspn(colon + 1, "0123456789") != strlen(colon + 1)) ||
        (strlen(colon + 1) > 6U)) {
        return false;
    }
    (void)snprintf(chip, size, "%.*s", (int)(colon - text), text);
    *line = (unsigned)strtoul(colon + 1, NULL, 10);
    return true;
}
