/* A CUDA driver without a card: `tests/benchmarks/ptx.py` loads it in place of libcuda.so.

   Memory is the computer's, kernels are written to the folder PTX_FOLDER and not run. So whatever a kernel would have
   written is zero, or what the host wrote there before. Only what Taichi 1.7 asks of a driver is here. */

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FINE = 0, WITHOUT = 1, NO_MEMORY = 2 };

static size_t modules;

static FILE *opened(const char *name) {
  char path[4096];
  const char *folder = getenv("PTX_FOLDER");
  snprintf(path, sizeof path, "%s/%s", folder ? folder : ".", name);
  FILE *file = fopen(path, "w");
  if (!file) {
    perror(path);
    exit(2);
  }
  return file;
}

static int made(void **handle) { *handle = (void *)1; return FINE; }

/* Device: compute capability 9.0, as of an H100. Taichi 1.7 compiles for 8.6 at most. */
int cuInit(int flags) { return FINE; }
int cuDriverGetVersion(int *version) { *version = 12000; return FINE; }
int cuDeviceGetCount(int *count) { *count = 1; return FINE; }
int cuDeviceGet(int *device, int ordinal) { *device = 0; return FINE; }
int cuDeviceGetName(char *name, int length, int device) { snprintf(name, length, "no card"); return FINE; }
int cuDeviceGetAttribute(int *value, int attribute, int device) {
  switch (attribute) {
    case 1: *value = 1024; break;    /* most threads a block */
    case 8: *value = 49152; break;   /* shared memory of a block [bytes] */
    case 16: *value = 132; break;    /* multiprocessors */
    case 39: *value = 2048; break;   /* most threads a multiprocessor */
    case 75: *value = 9; break;      /* compute capability, major */
    case 76: *value = 0; break;      /* minor */
    case 97: *value = 232448; break; /* shared memory of a block that asks for more [bytes] */
    default: *value = 1;             /* memory pools among them */
  }
  return FINE;
}
int cuDeviceGetDefaultMemPool(void **pool, int device) { return made(pool); }
int cuMemPoolSetAttribute(void *pool, int attribute, void *value) { return FINE; }

/* Contexts, streams and events: one of each. */
int cuDevicePrimaryCtxRetain(void **context, int device) { return made(context); }
int cuCtxCreate_v2(void **context, int flags, int device) { return made(context); }
int cuCtxSetCurrent(void *context) { return FINE; }
int cuCtxGetCurrent(void **context) { return made(context); }
int cuCtxSetLimit(int limit, size_t value) { return FINE; }
int cuStreamCreate(void **stream, unsigned flags) { return made(stream); }
int cuStreamSynchronize(void *stream) { return FINE; }
int cuEventCreate(void **event, unsigned flags) { return made(event); }
int cuEventDestroy(void *event) { return FINE; }
int cuEventRecord(void *event, void *stream) { return FINE; }
int cuEventSynchronize(void *event) { return FINE; }
int cuEventElapsedTime(float *ms, void *start, void *end) { *ms = 0.0f; return FINE; }

/* Memory. */
int cuMemAlloc_v2(void **memory, size_t bytes) { return (*memory = calloc(1, bytes)) ? FINE : NO_MEMORY; }
int cuMemAllocAsync(void **memory, size_t bytes, void *stream) { return cuMemAlloc_v2(memory, bytes); }
int cuMemAllocManaged(void **memory, size_t bytes, unsigned flags) { return cuMemAlloc_v2(memory, bytes); }
int cuMemFree_v2(void *memory) { free(memory); return FINE; }
int cuMemFreeAsync(void *memory, void *stream) { return cuMemFree_v2(memory); }
int cuMemAdvise(void *memory, size_t bytes, int advice, int device) { return FINE; }
int cuMemGetInfo_v2(size_t *left, size_t *all) { *left = *all = (size_t)8 << 30; return FINE; }
int cuMemcpyDtoD_v2(void *to, const void *from, size_t bytes) { memmove(to, from, bytes); return FINE; }
int cuMemcpyHtoD_v2(void *to, const void *from, size_t bytes) { return cuMemcpyDtoD_v2(to, from, bytes); }
int cuMemcpyDtoH_v2(void *to, const void *from, size_t bytes) { return cuMemcpyDtoD_v2(to, from, bytes); }
int cuMemcpyHtoDAsync_v2(void *to, const void *from, size_t bytes, void *stream) {
  return cuMemcpyDtoD_v2(to, from, bytes);
}
int cuMemcpyDtoHAsync_v2(void *to, const void *from, size_t bytes, void *stream) {
  return cuMemcpyDtoD_v2(to, from, bytes);
}
int cuMemsetD8_v2(void *memory, unsigned char value, size_t count) { memset(memory, value, count); return FINE; }
int cuMemsetD32_v2(unsigned *memory, unsigned value, size_t count) {
  for (size_t i = 0; i < count; i++) memory[i] = value;
  return FINE;
}
int cuPointerGetAttribute(void *value, int attribute, void *pointer) { return WITHOUT; }

/* Kernels. */
int cuModuleLoadDataEx(void **module, const char *ptx, unsigned count, int *options, void **values) {
  char name[32];
  snprintf(name, sizeof name, "%05zu.ptx", modules++);
  FILE *file = opened(name);
  fputs(ptx, file);
  fclose(file);
  *module = (void *)modules;
  return FINE;
}
int cuModuleGetFunction(void **function, void *module, const char *name) {
  return (*function = strdup(name)) ? FINE : NO_MEMORY;
}
int cuLaunchKernel(const char *name, unsigned blocks, unsigned y, unsigned z, unsigned threads, unsigned threads_y,
                   unsigned threads_z, unsigned shared, void *stream, void **arguments, void **extra) {
  static FILE *launches;
  if (!launches) launches = opened("launches");
  fprintf(launches, "%s %u %u\n", name, blocks, threads);
  return fflush(launches) ? WITHOUT : FINE;
}
int cuFuncGetAttribute(int *value, int attribute, void *function) { *value = 0; return FINE; }
int cuFuncSetAttribute(void *function, int attribute, int value) { return FINE; }
int cuOccupancyMaxActiveBlocksPerMultiprocessor(int *blocks, void *function, int threads, size_t shared) {
  *blocks = 16;
  return FINE;
}
int cuGetErrorName(int code, const char **text) { *text = code == NO_MEMORY ? "no memory" : "not without a card"; return FINE; }
int cuGetErrorString(int code, const char **text) { return cuGetErrorName(code, text); }

/* Exchange with Vulkan. */
int cuImportExternalMemory(void) { return WITHOUT; }
int cuExternalMemoryGetMappedBuffer(void) { return WITHOUT; }
int cuExternalMemoryGetMappedMipmappedArray(void) { return WITHOUT; }
int cuMipmappedArrayGetLevel(void) { return WITHOUT; }
int cuSurfObjectCreate(void) { return WITHOUT; }
int cuSignalExternalSemaphoresAsync(void) { return WITHOUT; }
int cuWaitExternalSemaphoresAsync(void) { return WITHOUT; }
int cuImportExternalSemaphore(void) { return WITHOUT; }
