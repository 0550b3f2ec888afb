// Mean and scatter of what the threads of a workgroup have seen, weighed by probability (Chan, Golub & LeVeque 1983).

// A sum and what rounding has left out of it.
struct Compensated {
    sum: vec3<f32>,
    rest: vec3<f32>,
}

// Neumaier's.
fn plus(a: Compensated, b: vec3<f32>) -> Compensated {
    let sum = a.sum + b;
    let rest = select((b - sum) + a.sum, (a.sum - sum) + b, abs(a.sum) >= abs(b));
    return Compensated(sum, a.rest + rest);
}

struct Scatter {
    probability: f32,
    // The mean as box moments give it, about which squares are summed.
    mean: vec3<f32>,
    squares: vec3<f32>,
    // The exact mean, as a sum.
    sum: Compensated,
}

fn joined(a: Scatter, b: Scatter) -> Scatter {
    let probability = a.probability + b.probability;
    let share = b.probability / max(probability, 1e-30);
    let apart = b.mean - a.mean;
    let sum = plus(a.sum, b.sum.sum);
    return Scatter(
        probability,
        a.mean + share * apart,
        a.squares + b.squares + (share * a.probability) * apart * apart,
        Compensated(sum.sum, sum.rest + b.sum.rest),
    );
}

// Of all threads, for the first one. Few barriers: they are dear on a software renderer.
fn scatter_of_threads(own: Scatter, thread: u32) -> Scatter {
    scatters[thread] = own;
    workgroupBarrier();
    var all = own;
    if thread < ROOTS {
        for (var k = thread + ROOTS; k < THREADS; k += ROOTS) {
            all = joined(all, scatters[k]);
        }
        scatters[thread] = all;
    }
    workgroupBarrier();
    if thread == 0u {
        for (var k = 1u; k < ROOTS; k++) {
            all = joined(all, scatters[k]);
        }
    }
    return all;
}
