// Stands where the Vulkan loader stands, hands everything on to it, and loses the device: CROWD_LOSE_SUBMIT=n from the nth submission on,
// CROWD_LOSE_WAIT=n from the nth wait on. CROWD_VULKAN is the loader's own file.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define LOST (-4)
typedef void (*Function)(void);
typedef Function (*Get)(void *, const char *);
static Get of_instance, of_device;
static int submissions, waits;

static int from(const char *name, int count) {
    const char *first = getenv(name);
    return first && count >= atoi(first);
}
static int is_lost(void) { return from("CROWD_LOSE_SUBMIT", submissions) || from("CROWD_LOSE_WAIT", waits); }

static int (*submit)(void *, uint32_t, const void *, uint64_t);
static int lose_submit(void *queue, uint32_t count, const void *all, uint64_t fence) {
    submissions++;
    return is_lost() ? LOST : submit(queue, count, all, fence);
}
static int (*wait)(void *, const void *, uint64_t);
static int lose_wait(void *device, const void *info, uint64_t timeout) {
    waits++;
    return is_lost() ? LOST : wait(device, info, timeout);
}
static int (*acquire)(void *, uint64_t, uint64_t, uint64_t, uint64_t, uint32_t *);
static int lose_acquire(void *device, uint64_t chain, uint64_t timeout, uint64_t semaphore, uint64_t fence, uint32_t *image) {
    return is_lost() ? LOST : acquire(device, chain, timeout, semaphore, fence, image);
}
static int (*present)(void *, const void *);
static int lose_present(void *queue, const void *info) { return is_lost() ? LOST : present(queue, info); }

static Function in_place_of(const char *name, Function found) {
#define REPLACE(vulkan, kept, ours) \
    if (found && !strcmp(name, vulkan)) { \
        kept = (void *)found; \
        return (Function)ours; \
    }
    REPLACE("vkQueueSubmit", submit, lose_submit)
    REPLACE("vkWaitSemaphores", wait, lose_wait)
    REPLACE("vkWaitSemaphoresKHR", wait, lose_wait)
    REPLACE("vkAcquireNextImageKHR", acquire, lose_acquire)
    REPLACE("vkQueuePresentKHR", present, lose_present)
    return found;
}

static Function get_of_device(void *device, const char *name) { return in_place_of(name, of_device(device, name)); }

Function vkGetInstanceProcAddr(void *instance, const char *name) {
    if (!of_instance) {
        void *loader = dlopen(getenv("CROWD_VULKAN"), RTLD_NOW | RTLD_LOCAL);
        if (!loader) return 0;
        of_instance = (Get)dlsym(loader, "vkGetInstanceProcAddr");
    }
    Function found = of_instance(instance, name);
    if (found && !strcmp(name, "vkGetDeviceProcAddr")) {
        of_device = (Get)found;
        return (Function)get_of_device;
    }
    return in_place_of(name, found);
}
