/* davar-sim - the unit of a column, from the end of its name. */
#ifndef UNIT_H
#define UNIT_H

typedef enum {
    UNIT_DPS = 0, /* deg/s, unchanged */
    UNIT_RAD_S,   /* rad/s, converted to deg/s */
    UNIT_COUNTS,  /* whole counts, scaled by --lsb */
    UNIT_OTHER    /* not a rate: processed in its own unit */
} unit_t;

unit_t unit_of(const char *column);

/* deg/s per unit of the column; 1 for counts and for columns that are not rates. */
double unit_factor(unit_t unit);

#endif
