// The backward pass: every estimate gets to know what came after it. Its carrier is not a state but
// the gradient λ of what is unlikely about the later measurements, with its curvature Λ, taken
// against the flow of time through the transposed transitions: no covariance is inverted, and none
// but those of the moments asked for need be kept (G. J. Bierman, Fixed interval smoothing with
// discrete measurements, International Journal of Control 18(1), 1973). Transitions are made again
// from the samples, event by event.

#pragma once

#include "history.h"

namespace motorcade::filter {

template <std::size_t N> class Filter final : public Timeline<N> {
public:
    using Timeline<N>::Timeline;

    // Rewrites what the sink holds for the moments passed so far. Between states that were kept all
    // is made again first. The state ends where it started.
    void smooth() {
        Matrix<N> curvature;
        double gradient[N] = {};
        this->thorough_ = true;
        for (std::size_t end = this->next_; end > 0;) {
            std::size_t kept = end > 1 ? end - 2 : 0;
            while (!this->events_[kept].known) --kept;
            const std::size_t first = end > 1 ? kept + 1 : 0;
            if (first > 0) this->replay(first, end);
            for (std::size_t i = end; i-- > first;) {
                Event &event = this->events_[i];
                if (event.kind == Kind::output) rewrite(event, gradient, curvature);
                if (event.measures() && event.factor > 0.0 && i > 0)
                    take_in(event, gradient, curvature);
                if (event.kind == Kind::keep) unkeep(gradient, curvature);
                if (i > 0) step_back(this->events_[i - 1], event.time_ns, gradient, curvature);
                event.known.reset();
                event.linear = std::vector<double>();
            }
            end = first;
        }
    }

private:
    void step_back(const Event &from, std::int64_t to, double *gradient, Matrix<N> &curvature) {
        steps_.clear();
        this->now_ = from.known->after;
        this->seek(from.time_ns);
        this->advance(to, [this](const Transition &f, const Densities &) { steps_.push_back(f); });
        for (std::size_t k = steps_.size(); k-- > 0;)
            propagate_back(curvature, gradient, steps_[k]);
        symmetrise(curvature);
    }

    // λ becomes (1 - K H)' λ - H' S⁻¹ y, and Λ likewise with H' S⁻¹ H added.
    void take_in(const Event &event, double *gradient, Matrix<N> &curvature) {
        const std::size_t m = event.size;
        const double *residual = event.linear.data(), *effect = residual + m,
                     *gain = effect + m * N, *inverse = gain + m * N;
        Innovation<N> seen;
        Gain<N> by;
        seen.size = m;
        double pull[widest];
        for (std::size_t a = 0; a < m; ++a) {
            std::copy_n(effect + a * N, N, seen.effect[a]);
            std::copy_n(gain + a * N, N, by.gain[a]);
            std::copy_n(inverse + a * m, m, by.inverse[a]);
            pull[a] = 0.0;
            for (std::size_t i = 0; i < N; ++i) pull[a] += by.gain[a][i] * gradient[i];
            for (std::size_t b = 0; b < m; ++b) pull[a] += by.inverse[a][b] * residual[b];
        }
        for (std::size_t a = 0; a < m; ++a) filter::add<N>(gradient, -pull[a], seen.effect[a]);
        update_back(curvature, seen, by);
    }

    // Before the pose was kept there was but one: what is said of the earlier one is said of it.
    static void unkeep(double *gradient, Matrix<N> &curvature) {
        if constexpr (N > earlier) {
            for (std::size_t i = 0; i < 6; ++i) {
                gradient[i] += gradient[earlier + i];
                gradient[earlier + i] = 0.0;
                filter::add<N>(curvature.row[i], 1.0, curvature.row[earlier + i]);
                std::fill_n(curvature.row[earlier + i], N, 0.0);
            }
            for (std::size_t k = 0; k < N; ++k)
                for (std::size_t i = 0; i < 6; ++i) {
                    curvature.row[k][i] += curvature.row[k][earlier + i];
                    curvature.row[k][earlier + i] = 0.0;
                }
        }
    }

    // x Exp(-P λ) and P - P Λ P in place of what the forward pass wrote.
    void rewrite(const Event &event, const double *gradient, const Matrix<N> &curvature) {
        Matrix<N> p;
        double error[N] = {};
        unpack(event.known->covariance, p);
        for (std::size_t i = 0; i < N; ++i)
            for (std::size_t k = 0; k < N; ++k) error[i] -= p.row[i][k] * gradient[k];
        shrink(p, curvature);
        this->now_ = event.known->after;
        correct<N>(this->now_, error);
        this->put(event.number, p);
    }

    std::vector<Transition> steps_;  // of one interval, kept for its memory
};

}  // namespace motorcade::filter
