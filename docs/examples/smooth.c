/*
 * Smooths poses from the standard input to the standard output, EuRoC's columns:
 *
 *     cc -std=c99 -O2 -I"$(python -c 'from motorcade.fusion.smoothing.header import get_include
 *     print(get_include())')" smooth.c -o smooth -lm
 *     ./smooth rts < noisy.csv > smoothed.csv
 *
 * Rows hold time_ns,x,y,z,qw,qx,qy,qz. The method is rts (all poses inform every one), velocity or
 * one_euro (each knows only its past, as in a live program).
 */
#include "motorcade/smooth.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Motors and stamps that were read, in memory that grows. */
typedef struct poses {
    double *motors;
    int64_t *time_ns;
    size_t count, room;
} poses;

static int refused(const char *what, size_t row) {
    fprintf(stderr, "smooth: row %zu: %s\n", row + 1, what);
    return 1;
}

static int grow(poses *all) {
    const size_t room = all->room ? 2 * all->room : 1024;
    double *motors = (double *)realloc(all->motors, room * 8 * sizeof(double));
    if (motors != NULL) all->motors = motors;
    int64_t *time_ns = (int64_t *)realloc(all->time_ns, room * sizeof(int64_t));
    if (time_ns != NULL) all->time_ns = time_ns;
    if (motors == NULL || time_ns == NULL) return refused("out of memory", all->count);
    all->room = room;
    return 0;
}

static int read_poses(poses *all) {
    char line[512];
    while (fgets(line, sizeof line, stdin) != NULL) {
        double p[3], q[4];
        int64_t time_ns;
        if (line[0] == '#' || line[0] == '\n') continue;
        if (all->count == all->room && grow(all) != 0) return 1;
        if (sscanf(line, "%" SCNd64 ",%lf,%lf,%lf,%lf,%lf,%lf,%lf", &time_ns, &p[0], &p[1], &p[2],
                   &q[0], &q[1], &q[2], &q[3]) != 8)
            return refused("expected time_ns,x,y,z,qw,qx,qy,qz", all->count);
        all->time_ns[all->count] = time_ns;
        motorcade_motor_of_pose(p, q, all->motors + 8 * all->count++);
    }
    return 0;
}

/* In place. */
static int smoothed_by_rts(poses *all) {
    const motorcade_model model = motorcade_constant_velocity();
    const size_t needed = motorcade_rts_work(all->count);
    motorcade_kalman *work = (motorcade_kalman *)malloc((needed + 1) * sizeof *work);
    if (work == NULL) return refused("out of memory", all->count);
    const int status =
        motorcade_rts(&model, all->motors, all->time_ns, all->count, NULL, all->motors, NULL, work);
    free(work);
    if (status == MOTORCADE_OK) return 0;
    fprintf(stderr, "smooth: %s\n", motorcade_message(status)); /* of which row it does not say */
    return 1;
}

static int filtered(poses *all, int by_one_euro) {
    motorcade_one_euro one_euro;
    motorcade_kalman kalman;
    const motorcade_model model = motorcade_constant_velocity();
    motorcade_one_euro_start(&one_euro, 1.0, 100.0, 100.0, 1.0);
    motorcade_kalman_start(&kalman, &model);
    for (size_t k = 0; k < all->count; ++k) {
        double *motor = all->motors + 8 * k;
        const int status = by_one_euro
                               ? motorcade_one_euro_update(&one_euro, motor, all->time_ns[k], motor)
                               : motorcade_kalman_update(&kalman, motor, all->time_ns[k], motor);
        if (status != MOTORCADE_OK) return refused(motorcade_message(status), k);
    }
    return 0;
}

int main(int count, char **arguments) {
    poses all = {NULL, NULL, 0, 0};
    const char *method = count == 2 ? arguments[1] : "";
    int failed = 2;
    if (strcmp(method, "rts") != 0 && strcmp(method, "velocity") != 0 &&
        strcmp(method, "one_euro") != 0)
        fprintf(stderr, "usage: smooth rts|velocity|one_euro < poses.csv > smoothed.csv\n");
    else if ((failed = read_poses(&all)) == 0)
        failed = strcmp(method, "rts") == 0 ? smoothed_by_rts(&all)
                                            : filtered(&all, strcmp(method, "one_euro") == 0);
    for (size_t k = 0; k < all.count && failed == 0; ++k) {
        double p[3], q[4];
        motorcade_pose_of_motor(all.motors + 8 * k, p, q);
        printf("%" PRId64 ",%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", all.time_ns[k], p[0],
               p[1], p[2], q[0], q[1], q[2], q[3]);
    }
    free(all.motors);
    free(all.time_ns);
    return failed;
}
