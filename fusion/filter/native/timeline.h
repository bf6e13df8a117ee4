// Inertial samples and events in the order of time, and the state that is propagated along them.
// Live streams and whole recordings go through the same code: samples are added one after another,
// events wait until the samples reach them, and one that comes late is put where it belongs, after
// which everything since is done again from the nearest state that was kept.

#pragma once

#include <algorithm>
#include <array>
#include <deque>
#include <optional>
#include <stdexcept>
#include <string>

#include "measurement.h"
#include "samples.h"

namespace motorcade::filter {

struct Settings {
    double gravity_m_s2;
    Densities noise;
    std::array<double, 5> start_sigma;      // turn, position, velocity, both biases, at the start
    double start_tilt_rad;                  // how wrong the start is made on purpose
    std::array<double, 4> known_sigma;      // tilt, extrinsics' turn and shift, time offset
    std::array<double, widest + 1> gate;    // of χ², by degrees of freedom
    std::array<double, widest + 1> middle;  // half of good measurements stay below
    double most_noise;           // beyond so many times its noise a measurement is left out
    std::int64_t gap_ns;         // longer intervals between samples lack data
    double gap_rate, gap_force;  // deviations of what was not felt in them
    std::int64_t history_ns;     // how late an event may come
    std::int64_t lag_ns;         // how much later what is settled may look back; see window.h
    std::size_t check_every;     // samples between kept states; 0: at events only
};

// See candidates.h.
template <std::size_t N> struct Track;
template <std::size_t N> struct Candidate;

// In a whole recording the state is kept at every so many events, and made again between them.
constexpr std::size_t stride = 64;

// Where the path is written as it passes the moments asked for; rows by the events' numbers. Of the
// covariance, that of the camera's pose (6, 6), and where it is asked for that of the error.
struct Sink {
    double *pose = nullptr, *velocity = nullptr, *bias = nullptr, *covariance = nullptr,
           *others = nullptr;
    double *whole = nullptr;
    std::size_t size = 0;  // so many numbers of the error, the first ones
    bool final = false;    // also when things are done again
};

[[noreturn]] inline void refuse(const std::string &what) { throw std::invalid_argument(what); }

template <std::size_t N> class Timeline {
public:
    Timeline(const Settings &settings, const State &first)
        : settings_(settings), motion_(settings.gravity_m_s2), first_(first) {}
    // Adds a sample and moves everything on to it.
    void imu(const Sample &sample) {
        if (!samples_.empty() && sample.time_ns <= samples_.back().time_ns)
            refuse("imu: expected a stamp after " + std::to_string(samples_.back().time_ns) +
                   ", got " + std::to_string(sample.time_ns));
        double total = 0.0;
        for (int i = 0; i < 3; ++i) total += 0.0 * sample.read.rate[i] + 0.0 * sample.read.force[i];
        if (total != 0.0) refuse("imu: expected finite numbers, got others");
        samples_.push_back(sample);
        catch_up();
        if (settings_.check_every != 0 && ++unchecked_ >= settings_.check_every) keep_and_forget();
    }

    // Takes the samples of a whole recording, rising and finite, where the caller holds them.
    void hold(const std::int64_t *time_ns, const double *rate, const double *force,
              std::size_t count) {
        if (settings_.check_every != 0 || !samples_.empty())
            refuse("hold: expected a filter of a whole recording");
        samples_.hold(time_ns, rate, force, count);
        samples_.show();
    }

    // Moves everything on to the next sample held, or the one that the next event waits for; false
    // where none is left.
    bool play(bool by_sample) {
        const bool waits = next_ < events_.size();
        const std::int64_t until = waits ? events_[next_].time_ns : INT64_MAX;
        if (!(by_sample ? samples_.show() : samples_.show_until(until))) return false;
        catch_up();
        return true;
    }

    // Takes an event at any time that the history still holds.
    void add(Event &&event) {
        place_in_time(event, events_.empty() ? nullptr : &events_.front());
        if (started_ && event.measures()) settle_before(event.time_ns);
        const auto place = std::upper_bound(events_.begin(), events_.end(), event, precedes);
        const auto index = static_cast<std::size_t>(place - events_.begin());
        const bool late = index < next_ || (started_ && event.time_ns < time_ns_);
        events_.insert(place, std::move(event));
        if (started_) shift_candidates(index, 1);
        if (late) {
            const bool newest = index == next_;
            replay(index, ++next_);
            if (newest) consider(index);
        }
        catch_up();
    }

    // Takes so many events that rise in time, none of them late; `make` gives one after another.
    template <class Make> void schedule(std::size_t count, Make &&make) {
        std::deque<Event> rising, merged;
        for (std::size_t k = 0; k < count; ++k) {
            rising.push_back(make(k));
            Event &event = rising.back();
            const std::deque<Event> &all = events_.empty() ? rising : events_;
            place_in_time(event, &all.front() == &event ? nullptr : &all.front());
            if (started_ && event.time_ns < time_ns_)
                refuse("schedule: expected stamps still ahead");
        }
        // From the end on, so that each list gives back what the other takes.
        while (!rising.empty()) {
            const bool wait = events_.size() > next_ && precedes(rising.back(), events_.back());
            std::deque<Event> &later = wait ? events_ : rising;
            merged.push_front(std::move(later.back()));
            later.pop_back();
        }
        for (; !merged.empty(); merged.pop_front()) events_.push_back(std::move(merged.front()));
        catch_up();
    }

    bool started() const { return started_; }
    const State &state() const { return now_; }
    const Matrix<N> &covariance() const { return p_; }
    std::int64_t time_ns() const { return time_ns_; }
    const std::deque<Event> &events() const { return events_; }
    std::size_t done() const { return next_; }
    // Spans in which the state was given up later: first and last moment of each.
    const std::vector<std::array<std::int64_t, 2>> &given_up() const { return given_up_; }
    // The first measurement left out since one was believed.
    std::optional<std::int64_t> contradicted_since() const {
        return denied_ == 0 ? std::nullopt : std::optional(doubted_ns_);
    }
    const Samples &samples() const { return samples_; }
    Sink sink;

protected:
    // Propagates the state to a moment within the samples; `each` sees every transition.
    template <class Each> void advance(std::int64_t to, Each &&each) {
        if (!(time_ns_ < to)) return;
        double fall[3];
        motion_.gravity(now_, fall);
        while (time_ns_ < to && sample_ + 1 < samples_.size()) {
            const Sample one = samples_[sample_], next = samples_[sample_ + 1];
            const std::int64_t end = std::min(to, next.time_ns);
            const Reading here = time_ns_ == one.time_ns ? one.read : reading(time_ns_),
                          there = end == next.time_ns ? next.read : reading(end);
            Reading mean;
            for (int i = 0; i < 3; ++i) {
                mean.rate[i] = 0.5 * (here.rate[i] + there.rate[i]);
                mean.force[i] = 0.5 * (here.force[i] + there.force[i]);
            }
            const double whole = 1e-9 * static_cast<double>(end - time_ns_);
            const Densities noise = densities(next.time_ns - one.time_ns);
            const int parts = Motion::parts(now_, mean, whole);
            for (int k = 0; k < parts; ++k) {
                Transition transition;
                motion_.step<N>(now_, mean, whole / parts, fall, transition);
                each(transition, noise);
            }
            time_ns_ = end;
            if (end == next.time_ns) ++sample_;
        }
    }

    void seek(std::int64_t time_ns) {
        sample_ = samples_.after(time_ns) - 1;
        time_ns_ = time_ns;
    }

    void advance_to(std::int64_t to) {
        advance(to, [this](const Transition &f, const Densities &q) { propagate(p_, f, q); });
    }

    // See hypothesis.h.
    void replay(std::size_t from, std::size_t to);
    void doubt_last_jump(std::size_t since);
    bool bridged_back(std::size_t from, std::size_t to, Track<N> &after);
    bool doubt_first_jump(std::size_t jump, Track<N> after);
    void restart(const State &at) { begun_ = at; }
    void begin_at(std::size_t index);
    static void relocate(State &state, const Event &event, bool turned);
    std::size_t judge_before(Track<N> track, std::size_t birth);
    void may_start(std::size_t index);
    void put(std::size_t row, const Matrix<N> &p) const;
    bool bridged(const Matrix<N> &covariance, const Event &event) const;
    bool strained(const Event &event) const;
    void reconsider();
    virtual void settle_before(std::int64_t) {}  // see window.h

    // What a measurement's noise is multiplied by, so that its pull is no more than that of one at
    // the gate, from its normalised squares with its own noise and with the most that it may have.
    // It is left out, by 0, where that is not enough, or where most of the square is the
    // prediction's: then more noise takes away little of the pull, and others must decide.
    double factor_of(double nis, double with_most, std::size_t freedom) const {
        const double limit = settings_.gate[freedom], most = settings_.most_noise;
        if (nis <= limit) return 1.0;
        const bool noisy = nis >= 0.5 * (1.0 + most) * with_most;
        return noisy && with_most <= limit ? std::min(nis / limit, most) : 0.0;
    }

    Settings settings_;
    Motion motion_;
    State first_, now_;
    Matrix<N> p_;
    std::int64_t time_ns_ = 0;
    std::size_t sample_ = 0;
    Samples samples_;
    std::deque<Event> events_;
    std::size_t next_ = 0;  // of the events, the first that waits
    bool started_ = false;
    std::optional<State> begun_;       // where the path starts, if not at the first pose
    std::size_t begin_ = 0;            // the event before which nothing is, while a start is tried
    std::vector<std::size_t> starts_;  // where it was denied near the start; may be the true one
    std::vector<std::array<std::int64_t, 2>> given_up_;
    bool thorough_ = false;  // every event keeps all that a backward pass needs
    std::size_t due_ = 0;    // of the events, the first that is not settled

private:
    Reading reading(std::int64_t t) const {
        const Sample one = samples_[sample_];
        if (t == one.time_ns) return one.read;
        const Sample next = samples_[sample_ + 1];
        const double part =
            static_cast<double>(t - one.time_ns) / static_cast<double>(next.time_ns - one.time_ns);
        Reading made;
        for (int i = 0; i < 3; ++i) {
            made.rate[i] = one.read.rate[i] + part * (next.read.rate[i] - one.read.rate[i]);
            made.force[i] = one.read.force[i] + part * (next.read.force[i] - one.read.force[i]);
        }
        return made;
    }

    // Through a gap in the data, rate and force may have been anything by a constant deviation.
    Densities densities(std::int64_t interval_ns) const {
        Densities made = settings_.noise;
        if (interval_ns <= settings_.gap_ns) return made;
        const double length = 1e-9 * static_cast<double>(interval_ns);
        made.rate += settings_.gap_rate * settings_.gap_rate * length;
        made.force += settings_.gap_force * settings_.gap_force * length;
        return made;
    }

    static bool precedes(const Event &one, const Event &other) { return one.before(other); }

    // `first`: of all events, where there is one already.
    void place_in_time(Event &event, const Event *first) const {
        event.time_ns = event.stamp_ns;
        if (event.kind == Kind::camera_pose || event.kind == Kind::corners) {
            const double delay_s = started_ ? now_.delay_s : first_.delay_s;
            event.time_ns += static_cast<std::int64_t>(std::llround(delay_s * 1e9));
        }
        check_time(event, first);
    }

    void check_time(const Event &event, const Event *first) const {
        if (samples_.empty())
            refuse("time_ns: expected inertial data before measurements, got none so far");
        const std::int64_t first_ns = first == nullptr ? samples_.front().time_ns : first->time_ns;
        if (event.time_ns < first_ns) {
            const std::string named = std::to_string(first_ns) + " on";
            refuse("time_ns: expected a stamp from " +
                   (first == nullptr ? named + ", where inertial data begin"
                    : forgotten_     ? named + ", which the history holds"
                                     : "the start at " + named) +
                   ", got " + std::to_string(event.stamp_ns));
        }
        if (first == nullptr && event.kind != Kind::camera_pose && event.kind != Kind::imu_pose)
            refuse("time_ns: expected a measured pose to start from, got another measurement");
    }

    void catch_up() {
        const std::int64_t horizon = samples_.back().time_ns;
        while (next_ < events_.size() && events_[next_].time_ns <= horizon) {
            if (started_ && events_[next_].measures()) settle_before(events_[next_].time_ns);
            process(next_++);
            consider(next_ - 1);
        }
        if (started_) advance_to(horizon);
    }

    void process(std::size_t index) {
        Event &event = events_[index];
        if (index < begin_) return;
        if (!started_) {
            start(event);
        } else {
            advance_to(event.time_ns);
            if (event.measures()) measure(event);
        }
        if (event.kind == Kind::output) write(event);
        if (event.kind == Kind::keep) keep_pose();
        keep(event, index);
        if (!event.judged) {
            event.live_nis = event.nis;
            event.live_factor = event.factor;
        }
        event.judged = true;
    }

    void keep(Event &event, std::size_t index) {
        const bool live = settings_.check_every != 0 && event.kind != Kind::output;
        if (!thorough_ && !live && (index - begin_) % stride != 0) {
            event.known.reset();
            return;
        }
        if (!event.known) event.known = std::make_unique<Known>();
        event.known->after = now_;
        event.known->covariance = packed(p_);
    }

    // See start.h.
    void measure(Event &event);
    bool predict(const Event &event, Innovation<N> &made) const;
    static void tells(Event &event, const Innovation<N> &innovation);
    void apply(const Innovation<N> &innovation, const Gain<N> &gain);

    // See start.h.
    void start(Event &event);
    void from_pose(const Event &event);
    template <class Do> void begin_wide(Do &&state);
    void unknown_at_start();
    double start_sigma(std::size_t k) const;
    void lean();
    void make_room(const Event &event, const Doubt &doubt);

    // See candidates.h.
    void consider(std::size_t index);
    void challenge(std::size_t index);
    bool agrees(Candidate<N> &candidate, const Event &event, double gates = 1.0);
    double believed(const Event &event, double gates = 1.0);
    void spawn(std::size_t index);
    void give_up(const Candidate<N> &candidate);
    bool imu_suffices(const Event &event) const;
    void undo_jump(std::size_t jump, std::size_t from, std::size_t to);
    void take_for_wrong(std::size_t from, std::size_t to);
    void undecide(std::size_t from);
    void turn_round();
    void retreat_to(std::int64_t to);
    void shift_candidates(std::size_t from, int by);
    template <class Do> void along(Track<N> &track, Do &&act);

    // See hypothesis.h.
    void keep_pose();
    void keep_linear(Event &event, const Innovation<N> &innovation, const Gain<N> &gain);
    void keep_and_forget();
    void write(Event &event);

    std::vector<Candidate<N>> candidates_;
    std::unique_ptr<Candidate<N>>
        former_;                 // the prediction given up last, as long as it may return
    std::size_t explained_ = 0;  // measurements believed so far
    std::size_t own_birth_ = 0, own_hits_ = 0;  // of the prediction since it was last given up
    std::size_t denied_ = 0;                    // in a row, the first of them at `doubted_ns_`
    std::int64_t doubted_ns_ = 0;
    std::size_t unchecked_ = 0;
    bool forgotten_ = false;
};

}  // namespace motorcade::filter
