/* Another date for a process and all that it starts: preloaded, it shifts what the wall clock shows.
 *
 * ROSIC_SHIFT_S is added to CLOCK_REALTIME, and taken off again from every moment until which somebody wants to wait by
 * that clock. The monotonic clocks, and those of the processor, are left alone: libfaketime 0.9.10 shifts what Python
 * sleeps by, or makes its sleep fail. The times of files are those of the disk.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdlib.h>
#include <sys/time.h>
#include <time.h>

static long shift_s(void) {
    static long known;
    static int asked;
    if (!asked) {
        const char *said = getenv("ROSIC_SHIFT_S");
        known = said ? atol(said) : 0;
        asked = 1;
    }
    return known;
}

/* The next one of this name; of two versions, the one that programs are linked with today. */
static void *next(const char *name) {
    void *found = dlvsym(RTLD_NEXT, name, "GLIBC_2.3.2");
    return found ? found : dlsym(RTLD_NEXT, name);
}

#define NEXT(result, name, ...)                              \
    static result (*real)(__VA_ARGS__);                      \
    if (!real) real = (result(*)(__VA_ARGS__))next(#name)

static int is_wall(clockid_t clock) {
    return clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE || clock == CLOCK_TAI;
}

static struct timespec unshifted(const struct timespec *until) {
    struct timespec real = *until;
    real.tv_sec -= shift_s();
    return real;
}

/* ---- what it shows ---- */

int clock_gettime(clockid_t clock, struct timespec *now) {
    NEXT(int, clock_gettime, clockid_t, struct timespec *);
    int failed = real(clock, now);
    if (!failed && is_wall(clock)) now->tv_sec += shift_s();
    return failed;
}

int gettimeofday(struct timeval *restrict now, void *restrict zone) {
    NEXT(int, gettimeofday, struct timeval *, void *);
    int failed = real(now, zone);
    if (!failed) now->tv_sec += shift_s();
    return failed;
}

time_t time(time_t *now) {
    struct timespec exact;
    clock_gettime(CLOCK_REALTIME, &exact);
    if (now) *now = exact.tv_sec;
    return exact.tv_sec;
}

int timespec_get(struct timespec *now, int base) {
    return base == TIME_UTC && !clock_gettime(CLOCK_REALTIME, now) ? base : 0;
}

/* ---- waiting until it shows something ---- */

int clock_nanosleep(clockid_t clock, int flags, const struct timespec *until, struct timespec *left) {
    NEXT(int, clock_nanosleep, clockid_t, int, const struct timespec *, struct timespec *);
    if (!is_wall(clock) || !(flags & TIMER_ABSTIME)) return real(clock, flags, until, left);
    struct timespec then = unshifted(until);
    return real(clock, flags, &then, left);
}

int pthread_cond_timedwait(pthread_cond_t *restrict condition, pthread_mutex_t *restrict mutex,
                           const struct timespec *restrict until) {
    NEXT(int, pthread_cond_timedwait, pthread_cond_t *, pthread_mutex_t *, const struct timespec *);
    /* A condition may go by the monotonic clock, which has not been running for thirty years. */
    if (until->tv_sec < 1000000000) return real(condition, mutex, until);
    struct timespec then = unshifted(until);
    return real(condition, mutex, &then);
}

int pthread_cond_clockwait(pthread_cond_t *condition, pthread_mutex_t *mutex, clockid_t clock,
                           const struct timespec *until) {
    NEXT(int, pthread_cond_clockwait, pthread_cond_t *, pthread_mutex_t *, clockid_t, const struct timespec *);
    struct timespec then = is_wall(clock) ? unshifted(until) : *until;
    return real(condition, mutex, clock, &then);
}

int pthread_mutex_timedlock(pthread_mutex_t *restrict mutex, const struct timespec *restrict until) {
    NEXT(int, pthread_mutex_timedlock, pthread_mutex_t *, const struct timespec *);
    struct timespec then = unshifted(until);
    return real(mutex, &then);
}

int pthread_mutex_clocklock(pthread_mutex_t *mutex, clockid_t clock, const struct timespec *until) {
    NEXT(int, pthread_mutex_clocklock, pthread_mutex_t *, clockid_t, const struct timespec *);
    struct timespec then = is_wall(clock) ? unshifted(until) : *until;
    return real(mutex, clock, &then);
}

int sem_timedwait(sem_t *restrict semaphore, const struct timespec *restrict until) {
    NEXT(int, sem_timedwait, sem_t *, const struct timespec *);
    struct timespec then = unshifted(until);
    return real(semaphore, &then);
}

int sem_clockwait(sem_t *semaphore, clockid_t clock, const struct timespec *until) {
    NEXT(int, sem_clockwait, sem_t *, clockid_t, const struct timespec *);
    struct timespec then = is_wall(clock) ? unshifted(until) : *until;
    return real(semaphore, clock, &then);
}
