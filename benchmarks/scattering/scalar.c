/* One look-up after the other, as a compiled renderer without vector instructions would do it: the yardstick for kernels.
 * The interpolation is that of `engine/scattering/table.py` for an isotropic table with alike sides. */
#include <math.h>

typedef struct {
    int count;
    const float *values;
} Axis;

static int place(const Axis *axis, float value, float *share)
{
    int low = 0, high = axis->count - 1;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (axis->values[middle] <= value) low = middle; else high = middle;
    }
    float s = (value - axis->values[low]) / (axis->values[high] - axis->values[low]);
    *share = s < 0.0f ? 0.0f : s > 1.0f ? 1.0f : s;
    return low;
}

void evaluate(int pairs, const float *wi, const float *wo, int asked, const float *nm, Axis incidences, Axis radials,
              Axis azimuths, Axis wavelengths, const float *values, float *result)
{
    for (int i = 0; i < pairs; ++i) {
        const float *a = wi + 3 * i, *b = wo + 3 * i;
        float sine = sqrtf(a[0] * a[0] + a[1] * a[1]);
        float c = sine > 0.0f ? a[0] / sine : 1.0f, s = sine > 0.0f ? a[1] / sine : 0.0f;
        float x = c * b[0] + s * b[1], y = c * b[1] - s * b[0];
        float centre = a[2] * b[2] - sine * x, outward = -a[2] * x - sine * b[2];
        float shares[3];
        int k = place(&incidences, atan2f(sine, a[2]), &shares[0]);
        int t = place(&radials, atan2f(sqrtf(outward * outward + y * y), centre), &shares[1]);
        int p = place(&azimuths, atan2f(fabsf(y), outward), &shares[2]);
        float weights[8];
        const float *corners[8];
        for (int corner = 0; corner < 8; ++corner) {
            int dk = corner & 1, dt = corner >> 1 & 1, dp = corner >> 2;
            weights[corner] = (dk ? shares[0] : 1.0f - shares[0]) * (dt ? shares[1] : 1.0f - shares[1]) *
                              (dp ? shares[2] : 1.0f - shares[2]);
            corners[corner] = values + (((long)(k + dk) * radials.count + t + dt) * azimuths.count + p + dp) *
                                           wavelengths.count;
        }
        for (int w = 0; w < asked; ++w) {
            float total = 0.0f;
            if (wavelengths.count == 1) {
                for (int corner = 0; corner < 8; ++corner) total += weights[corner] * corners[corner][0];
            } else {
                float part;
                int band = place(&wavelengths, nm[asked * i + w], &part);
                for (int corner = 0; corner < 8; ++corner) {
                    const float *at = corners[corner] + band;
                    total += weights[corner] * (at[0] + part * (at[1] - at[0]));
                }
            }
            result[asked * i + w] = total * b[2];
        }
    }
}
