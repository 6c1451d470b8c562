use super::Kernel;

#[test]
fn every_kernel_is_one_at_the_centre_and_zero_at_the_support() {
    for kernel in Kernel::ALL {
        assert!((kernel.value(0.0) - 1.0).abs() < 1e-7, "{kernel:?}");
        assert_eq!(kernel.value(1.0), 0.0);
        assert_eq!(kernel.value(2.0), 0.0);
        assert_eq!(Kernel::from_name(kernel.name()), Some(kernel));
    }
}

#[test]
fn inverse_undoes_value() {
    for kernel in Kernel::ALL {
        for i in 1..100 {
            let value = f64::from(i) / 100.0;
            let q = kernel.q_at(value).unwrap();
            assert!((kernel.value(q) - value).abs() < 1e-6, "{kernel:?} {value}");
        }
        assert_eq!(kernel.q_at(1.0), None);
        assert_eq!(kernel.q_at(0.0), None);
    }
}
